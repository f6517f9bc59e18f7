"""What every figure of the paper is made with: what it offers, where it is kept, how it looks."""
