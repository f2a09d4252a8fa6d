"""Whyroad on Spark: the calls of ``whyroad`` for one drive each, through ``mapInArrow``.

>>> result = whyroad.spark.mine(spark, "/shared/lake").persist()
>>> episodes, report = whyroad.spark.split(result)

Rows are those of ``Lake.mine`` and ``Lake.signals``, whatever the number of partitions and however often Spark tries a
task again. Every executor needs the lake under the same path. A drive that cannot be read, or on which the program
dies, is a ``failed`` row of the report.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from os import PathLike

import pyarrow as pa
from pyspark.sql import DataFrame, SparkSession
from pyspark.sql import functions as F
from pyspark.sql.pandas.types import from_arrow_schema

import whyroad
from whyroad.per_drive import FAILURE, REPORT, ROWS, STATUS, Mine, Signals, Work, lake_path, results, schema

Lake = str | PathLike[str] | whyroad.Lake


def mine(
    spark: SparkSession,
    lake: Lake,
    rule: str | None = None,
    *,
    target: str | None = None,
    scenario: str | None = None,
    drives: Sequence[str] | None = None,
    partitions: int | None = None,
    attempts: int = 2,
) -> DataFrame:
    """``Lake.mine`` of every drive."""
    return run(spark, Mine(lake_path(lake), rule, target, scenario), drives, partitions, attempts)


def signals(
    spark: SparkSession,
    lake: Lake,
    names: Sequence[str],
    drives: Sequence[str] | None = None,
    *,
    partitions: int | None = None,
    attempts: int = 2,
) -> DataFrame:
    """``Lake.signals`` of every drive. Names of signals have a dot: select them as ``F.col("`ego.speed`")``."""
    return run(spark, Signals(lake_path(lake), tuple(names)), drives, partitions, attempts)


def run(
    spark: SparkSession,
    work: Work,
    drives: Sequence[str] | None = None,
    partitions: int | None = None,
    attempts: int = 2,
) -> DataFrame:
    """Runs ``work`` on these drives, by default all of the lake. Default of ``partitions``: one per 16 drives."""
    ids = list(drives) if drives is not None else whyroad.open_lake(work.lake).drives()
    columns = schema(work)
    partitions = partitions or max(1, -(-len(ids) // 16))

    def each(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        wanted = (drive for batch in batches for drive in batch.column(0).to_pylist())
        for table in results(work, wanted, attempts):
            yield from table.combine_chunks().to_batches()

    frame = spark.createDataFrame([(i,) for i in ids], "drive_id string").repartition(partitions)
    return frame.mapInArrow(each, from_arrow_schema(columns))


def validate(labels: DataFrame, *, key: str, column: str = "label", lang: str = "en") -> DataFrame:
    """Findings of the JSON documents in ``column``, each with the ``key`` of its row."""
    kind = labels.schema[key].dataType.simpleString()
    texts = ", ".join(f"{name} string" for name in ("code", "severity", "message", "hint", "location"))

    def each(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            found = pa.table(whyroad.validate(batch, column=column, lang=lang))
            keys = pa.table(batch).column(key).take(found.column("row"))
            yield from found.drop_columns(["row"]).add_column(0, key, keys).combine_chunks().to_batches()

    return labels.select(key, column).mapInArrow(each, f"`{key}` {kind}, {texts}")


def split(result: DataFrame) -> tuple[DataFrame, DataFrame]:
    """Rows, and the report with one row per drive. Call ``persist()`` before, or the work is done twice."""
    rows = result.filter(F.col(STATUS) == "row").drop(STATUS, ROWS, FAILURE)
    return rows, result.filter(F.col(STATUS) != "row").select(*REPORT)
