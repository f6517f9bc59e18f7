"""Reports of comparisons: tables, figures, pictures of modes, and one page that holds them all."""

from comparisons.report.page import write_report

__all__ = ["write_report"]
