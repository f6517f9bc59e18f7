"""The engine of every study: cases -> rows -> sections of a page.

A study (:mod:`comparisons.study.study`) is a list of cases, a function that computes one, and
sections that show the rows. :func:`comparisons.study.run.run` runs it and resumes it where it was
killed, :func:`comparisons.study.page.write_study` writes record, CSV files, figures and the page. A
name in ``comparisons/cli/study.py`` makes it a command. ``docs/how_to_add_a_study.md`` has a whole
one.
"""
