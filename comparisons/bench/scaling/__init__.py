"""What more unknowns, higher degrees and more ranks cost: `cea bench scaling`."""
