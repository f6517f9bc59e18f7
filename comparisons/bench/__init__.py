"""What solving, assembling and more ranks cost, beside other programs: `cea bench`."""
