"""From operators to modes: pencils, drivers, modes, and matching of what they give."""
