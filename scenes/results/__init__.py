"""What running a scene gives, how it is stored, and what is compared of it."""
