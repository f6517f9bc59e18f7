"""What every application is made of: tables, numbers, plots, layout, processes for its runs."""
