"""Reports of comparisons: tables, figures, pictures of modes, and one page that holds them all."""
