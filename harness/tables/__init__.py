"""The two tables of a run, and the reader of the files that they are made from."""

from harness.tables.read import ResultsError, SceneJob, read_jobs
from harness.tables.schema import SchemaError, format_case, parse_case
from harness.tables.write import write_tables

__all__ = [
    "ResultsError",
    "SceneJob",
    "SchemaError",
    "format_case",
    "parse_case",
    "read_jobs",
    "write_tables",
]
