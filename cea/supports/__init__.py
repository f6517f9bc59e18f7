"""What holds and loads a body: supports, springs, pressures, forces."""
