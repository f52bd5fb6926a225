"""The compare-report: one self-contained HTML file, its figures as SVG and its tables as CSV."""

from harness.report.write import write_report

__all__ = ["write_report"]
