"""Tests of every contact formulation: patch tests, momentum, locking."""
