"""Every contact formulation put to the test: patch tests, locking, momentum, pairings."""
