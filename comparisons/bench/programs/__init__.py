"""Programs that assemble the same body, a file each; each runs in a process of its own."""
