"""Formulas of the benchmark: errors, intervals, equivalence, tiles, convergence and times.

Every metric is one function that names its source. Nothing here reads or writes a file.
"""
