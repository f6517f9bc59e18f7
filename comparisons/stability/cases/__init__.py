"""The catalogue, a file for each case: docs/how_to_add_a_stability_case.md tells how to add one."""
