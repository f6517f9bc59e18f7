"""What holds and loads a body: supports, springs, pressures, and the frames they are said in."""
