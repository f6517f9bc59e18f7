"""The page of `cea bench assembly`."""

from comparisons.bench.assembly.figures import FIGURES
from comparisons.bench.assembly.study import COMMAND
from comparisons.bench.assembly.tables import TABLES
from comparisons.bench.assembly.words import TITLE, summary
from comparisons.bench.report import Report

REPORT = Report(COMMAND, TITLE, summary, TABLES, FIGURES)
