"""The report of one run: `cea run --report`."""
