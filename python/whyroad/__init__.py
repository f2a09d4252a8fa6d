"""Chain-of-Causation driving data from Python: lakes, signals, episodes, labels and releases as Arrow tables.

>>> lake = whyroad.open_lake("lake")
>>> lake.mine("target.gap < 10 m for 1 s").to_pandas()

Tables implement the Arrow PyCapsule interface: ``pyarrow.table(t)``, ``polars.DataFrame(t)`` and DuckDB read them without
copies, and every function that takes a table takes those of other libraries. Failures are ``WhyroadError`` with the code
of the diagnostic.
"""

from whyroad._whyroad import Lake, Table, __version__, open_lake, read_parquet
from whyroad.checks import Finding, validate
from whyroad.errors import WhyroadError, WhyroadWarning
from whyroad.release import Release, SampleDataset, open_release

__all__ = [
    "Finding",
    "Lake",
    "Release",
    "SampleDataset",
    "Table",
    "WhyroadError",
    "WhyroadWarning",
    "__version__",
    "open_lake",
    "open_release",
    "read_parquet",
    "validate",
]
