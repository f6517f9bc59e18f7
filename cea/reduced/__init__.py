"""Parameter maps: a pencil projected on few vectors, with a bound for every eigenvalue."""
