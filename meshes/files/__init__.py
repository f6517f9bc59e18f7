"""What mesh files hold, as plain arrays: a reader for each format, and a body made of a part."""
