"""The page of `cea bench scaling`."""

from comparisons.bench.report import Report
from comparisons.bench.scaling.figures import FIGURES
from comparisons.bench.scaling.study import COMMAND
from comparisons.bench.scaling.tables import TABLES
from comparisons.bench.scaling.words import TITLE, summary

NOTES = (
    "The model: factors of nested dissection in space hold n^(4/3) numbers, making them takes n^2 "
    "operations, a solve n^(4/3); assembly and a step of multigrid take n. The largest run that "
    "was measured fixes the factors; work is spread evenly and steps of GMRES stay as they are, so "
    "that numbers are the least that would be needed. Multigrid serves at shifts left of all "
    "eigenvalues alone: there a search from zero needs ever more solves the higher the window.",
)

REPORT = Report(COMMAND, TITLE, summary, TABLES, FIGURES, NOTES)
