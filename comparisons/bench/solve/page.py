"""The page of `cea bench solve`."""

from comparisons.bench.report import Report
from comparisons.bench.solve.figures import FIGURES
from comparisons.bench.solve.study import COMMAND
from comparisons.bench.solve.tables import TABLES
from comparisons.bench.solve.words import TITLE, summary

REPORT = Report(COMMAND, TITLE, summary, TABLES, FIGURES)
