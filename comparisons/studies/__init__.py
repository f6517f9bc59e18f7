"""Studies of contact formulations: pure data out, drawn and tabulated apart from being computed."""
