"""The engine of every study: cases -> rows -> sections of a page.

``docs/how_to_add_a_study.md`` has a whole one; a name in ``comparisons/cli/study.py`` makes it a
command.
"""
