"""The paper's contact patch tests: Figures 2, 3 and 7 to 12."""
