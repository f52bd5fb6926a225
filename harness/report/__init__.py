"""The compare-report: one self-contained HTML file, its figures as SVG and its tables as CSV."""
