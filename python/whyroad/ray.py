"""Whyroad on Ray Data: the calls of ``whyroad`` for one drive each, spread over the workers of a cluster.

>>> result = whyroad.ray.mine("/shared/lake").materialize()
>>> episodes, report = whyroad.ray.split(result)

Rows are those of ``Lake.mine`` and ``Lake.signals``, whatever the number of workers and however often Ray tries a task
again. Every worker needs the lake under the same path. A drive that cannot be read, or on which the program dies, is a
``failed`` row of the report.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import ray.data

import whyroad
from whyroad.per_drive import FAILURE, REPORT, ROWS, STATUS, Mine, Signals, Work, lake_path, results

Lake = str | PathLike[str] | whyroad.Lake


def mine(
    lake: Lake,
    rule: str | None = None,
    *,
    target: str | None = None,
    scenario: str | None = None,
    drives: Sequence[str] | None = None,
    **options: Any,
) -> ray.data.Dataset:
    """``Lake.mine`` of every drive. ``options`` are those of :func:`run`."""
    return run(Mine(lake_path(lake), rule, target, scenario), drives, **options)


def signals(
    lake: Lake, names: Sequence[str], drives: Sequence[str] | None = None, **options: Any
) -> ray.data.Dataset:
    """``Lake.signals`` of every drive. ``options`` are those of :func:`run`."""
    return run(Signals(lake_path(lake), tuple(names)), drives, **options)


def run(
    work: Work,
    drives: Sequence[str] | None = None,
    *,
    drives_per_task: int = 16,
    attempts: int = 2,
    **options: Any,
) -> ray.data.Dataset:
    """Runs ``work`` on these drives, by default all of the lake. Further options are those of ``map_batches``."""
    ids = list(drives) if drives is not None else whyroad.open_lake(work.lake).drives()
    # A wrong rule or name fails here, and not in every task.
    work.run([])
    tasks = max(1, -(-len(ids) // drives_per_task))
    rows = ray.data.from_arrow(pa.table({"drive_id": pa.array(ids, pa.string())})).repartition(tasks)

    def each(batch: pa.Table) -> Iterator[pa.Table]:
        yield from results(work, batch.column("drive_id").to_pylist(), attempts)

    return rows.map_batches(each, batch_format="pyarrow", batch_size=None, **options)


def validate(
    labels: ray.data.Dataset, *, key: str, column: str = "label", lang: str = "en", **options: Any
) -> ray.data.Dataset:
    """Findings of the JSON documents in ``column``, each with the ``key`` of its row."""

    def each(batch: pa.Table) -> pa.Table:
        found = pa.table(whyroad.validate(batch, column=column, lang=lang))
        keys = batch.column(key).take(found.column("row"))
        return found.drop_columns(["row"]).add_column(0, key, keys)

    return labels.map_batches(each, batch_format="pyarrow", **options)


def split(result: ray.data.Dataset) -> tuple[ray.data.Dataset, ray.data.Dataset]:
    """Rows, and the report with one row per drive. Call ``materialize()`` before, or the work is done twice."""

    def rows(batch: pa.Table) -> pa.Table:
        mine = pa.compute.equal(batch.column(STATUS), "row")
        return batch.filter(mine).drop_columns([STATUS, ROWS, FAILURE])

    def report(batch: pa.Table) -> pa.Table:
        return batch.filter(pa.compute.not_equal(batch.column(STATUS), "row")).select(REPORT)

    return tuple(result.map_batches(f, batch_format="pyarrow") for f in (rows, report))  # type: ignore[return-value]


def _main() -> int:
    """``python -m whyroad.ray mine --lake LAKE --out DIR``: for job runners such as KubeRay."""
    parser = argparse.ArgumentParser(prog="python -m whyroad.ray", description=_main.__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("mine", help="episodes as Parquet files, and a report with one row per drive")
    command.add_argument("--lake", required=True)
    command.add_argument("--out", required=True, type=Path)
    command.add_argument("--rule")
    command.add_argument("--target")
    command.add_argument("--scenario")
    args = command.parse_args(sys.argv[2:]) if sys.argv[1:2] == ["mine"] else parser.parse_args()
    if args.out.exists():
        parser.error(f"{args.out} exists already")
    ids = whyroad.open_lake(args.lake).drives()
    made = mine(args.lake, args.rule, target=args.target, scenario=args.scenario, drives=ids).materialize()
    rows, report = split(made)
    reported = report.to_pandas()
    if sorted(reported["drive_id"]) != ids:
        raise RuntimeError("the report does not have every drive once; nothing was published")
    # Appears whole: written aside, then renamed.
    fresh = args.out.with_name(f".{args.out.name}.new")
    shutil.rmtree(fresh, ignore_errors=True)
    rows.write_parquet(str(fresh / "episodes"))
    pq.write_table(pa.Table.from_pandas(reported, preserve_index=False), fresh / "drives.parquet")
    os.rename(fresh, args.out)
    failed = reported[reported[STATUS] == "failed"]
    for drive, why in zip(failed["drive_id"], failed[FAILURE], strict=True):
        print(f"{drive}: {why}", file=sys.stderr)
    print(json.dumps({"drives": len(ids), "episodes": rows.count(), "failed": list(failed["drive_id"])}))
    return 3 if len(failed) else 0


if __name__ == "__main__":
    sys.exit(_main())
