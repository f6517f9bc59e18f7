"""What ``cea doctor`` looks at: whether this installation works, and what mends it where not."""
