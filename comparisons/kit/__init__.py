"""What the pages of every application are made of: tables, numbers, plots, layout."""
