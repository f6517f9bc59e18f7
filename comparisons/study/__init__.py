"""The engine of every study: ``docs/how_to_add_a_study.md`` has a whole one."""
