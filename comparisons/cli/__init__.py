"""The command line ``cea``."""
