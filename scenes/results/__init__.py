"""Results of scenes, their stored records, and the matching of modes of two runs."""
