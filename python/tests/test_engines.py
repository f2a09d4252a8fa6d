"""Ray Data and Spark give the rows of the embedded calls, whatever the number of tasks; a drive that kills its process
is set aside and named."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import whyroad
from whyroad.per_drive import FAILURE, REPORT, STATUS, Mine, portable, results

RULE = "target.gap < 40 m for 1 s"
#: Code of a drive that cannot be read, by what is done with it.
UNREADABLE = {"rule": "mine.drive.unreadable", "signals": "lake."}


@dataclass(frozen=True)
class Killing(Mine):
    """Kills its process on one drive, as one does that runs out of memory."""

    victim: str = ""

    def run(self, drives: list[str]) -> whyroad.Table:
        if self.victim in drives:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().run(drives)


@pytest.fixture(scope="session")
def lake(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The demo's lake with one drive more that cannot be read."""
    out = tmp_path_factory.mktemp("engines") / "lake"
    shutil.copytree(demo / "lake", out)
    first = sorted((out / "drives").iterdir())[0]
    broken = out / "drives" / "broken"
    shutil.copytree(first, broken, ignore=shutil.ignore_patterns("signals", "found.json"))
    (broken / "frames.parquet").write_bytes(b"PAR1")
    return out


def ordered(table: pa.Table) -> pa.Table:
    """Engines give partitions in any order; within a drive rows are in the embedded order, whose keys these are."""
    keys = ("drive_id", "keyframe_ns", "scenario_id", "target_id", "episode_id", "frame")
    keys = tuple(k for k in keys if k in table.column_names)
    return table.sort_by([(k, "ascending") for k in keys])


def embedded(lake: Path, work: str) -> pa.Table:
    """The same question without an engine."""
    opened = whyroad.open_lake(lake)
    drives = [d for d in opened.drives() if d != "broken"]
    if work == "signals":
        return ordered(portable(pa.table(opened.signals(["target.gap", "target.class"], drives=drives))))
    return ordered(portable(pa.table(opened.mine(RULE if work == "rule" else None, drives=drives))))


def same(rows: pa.Table, expected: pa.Table) -> None:
    assert expected.num_rows > 0
    assert rows.column_names == expected.column_names
    assert ordered(rows).cast(expected.schema).equals(expected)


def check_report(report: pa.Table, drives: list[str], failed: dict[str, str]) -> None:
    """Every drive once; those that failed with their reason."""
    assert sorted(report["drive_id"].to_pylist()) == drives
    found = {r["drive_id"]: r[FAILURE] for r in report.to_pylist() if r[STATUS] == "failed"}
    assert found.keys() == failed.keys()
    for drive, code in failed.items():
        assert code in found[drive]


def test_per_drive_without_an_engine(lake: Path) -> None:
    drives = whyroad.open_lake(lake).drives()
    work = Killing(str(lake), RULE, victim=drives[-1])
    made = pa.concat_tables(results(work, drives))
    report = made.filter(pa.compute.not_equal(made[STATUS], "row")).select(REPORT)
    check_report(report, drives, {"broken": UNREADABLE["rule"], drives[-1]: "mine.drive.kills_worker"})


@pytest.fixture(scope="session")
def ray() -> Iterator[Any]:
    module = pytest.importorskip("ray")
    # Tasks read the classes of this file.
    os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    os.environ["RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"] = "0"
    module.init(num_cpus=2, include_dashboard=False, object_store_memory=200_000_000, log_to_driver=False)
    module.data.DataContext.get_current().enable_progress_bars = False
    yield module
    module.shutdown()


def arrow(dataset: Any) -> pa.Table:
    tables = [pa.table(t) for t in dataset.iter_batches(batch_format="pyarrow", batch_size=None)]
    tables = [t for t in tables if t.num_rows]
    return pa.concat_tables(tables, promote_options="permissive")


@pytest.mark.parametrize("drives_per_task", [1, 100])
def test_ray_gives_the_embedded_rows(ray: Any, lake: Path, drives_per_task: int) -> None:
    import whyroad.ray

    drives = whyroad.open_lake(lake).drives()
    for work in ("rule", "signals") if drives_per_task == 1 else ("rule",):
        if work == "rule":
            result = whyroad.ray.mine(lake, RULE, drives_per_task=drives_per_task)
        else:
            result = whyroad.ray.signals(lake, ["target.gap", "target.class"], drives_per_task=drives_per_task)
        rows, report = whyroad.ray.split(result.materialize())
        same(arrow(rows), embedded(lake, work))
        check_report(arrow(report), drives, {"broken": UNREADABLE[work]})


def test_ray_sets_a_drive_aside_that_kills_its_process(ray: Any, lake: Path) -> None:
    import whyroad.ray

    drives = whyroad.open_lake(lake).drives()
    victim = drives[-1]
    result = whyroad.ray.run(Killing(str(lake), RULE, victim=victim), drives_per_task=2).materialize()
    rows, report = whyroad.ray.split(result)
    check_report(arrow(report), drives, {"broken": UNREADABLE["rule"], victim: "mine.drive.kills_worker"})
    expected = embedded(lake, "rule")
    same(arrow(rows), expected.filter(pa.compute.not_equal(expected["drive_id"], victim)))


def test_ray_validates_labels(ray: Any) -> None:
    import whyroad.ray

    labels = pa.table({"id": ["a", "b", "c"], "label": ["{", "[]", "{}"]})
    found = arrow(whyroad.ray.validate(ray.data.from_arrow(labels).repartition(3), key="id"))
    whole = pa.table(whyroad.validate(labels))
    expected = whole.drop_columns(["row"]).add_column(0, "id", labels["id"].take(whole["row"]))
    keys = [("id", "ascending"), ("code", "ascending"), ("location", "ascending")]
    assert expected.num_rows > 0
    assert found.sort_by(keys).cast(expected.schema).equals(expected.sort_by(keys))


def test_the_job_of_ray_publishes_whole_and_names_what_failed(ray: Any, lake: Path, tmp_path: Path) -> None:
    out = tmp_path / "episodes"
    command = [sys.executable, "-m", "whyroad.ray", "mine", "--lake", str(lake), "--rule", RULE, "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 3, done.stderr
    assert "broken: " in done.stderr
    same(pq.read_table(out / "episodes"), embedded(lake, "rule"))
    assert pq.read_table(out / "drives.parquet").num_rows == len(whyroad.open_lake(lake).drives())
    assert [p.name for p in tmp_path.iterdir()] == ["episodes"]


@pytest.fixture(scope="session")
def spark() -> Iterator[Any]:
    pytest.importorskip("pyspark")
    if not (shutil.which("java") or os.environ.get("JAVA_HOME")):
        pytest.skip("Spark needs Java")
    from pyspark.sql import SparkSession

    os.environ["PYSPARK_PYTHON"] = sys.executable
    os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    builder = SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false")
    session = builder.config("spark.sql.shuffle.partitions", "2").config("spark.driver.memory", "1g").getOrCreate()
    session.sparkContext.setLogLevel("ERROR")
    yield session
    session.stop()


@pytest.mark.parametrize("partitions", [1, 5])
def test_spark_gives_the_embedded_rows(spark: Any, lake: Path, partitions: int) -> None:
    import whyroad.spark

    drives = whyroad.open_lake(lake).drives()
    for work in ("rule", "signals") if partitions == 5 else ("rule",):
        if work == "rule":
            result = whyroad.spark.mine(spark, lake, RULE, partitions=partitions)
        else:
            result = whyroad.spark.signals(spark, lake, ["target.gap", "target.class"], partitions=partitions)
        rows, report = whyroad.spark.split(result.persist())
        same(rows.toArrow(), embedded(lake, work))
        check_report(report.toArrow(), drives, {"broken": UNREADABLE[work]})
        result.unpersist()


def test_spark_sets_a_drive_aside_and_validates(spark: Any, lake: Path) -> None:
    import whyroad.spark

    drives = whyroad.open_lake(lake).drives()
    victim = drives[-1]
    result = whyroad.spark.run(spark, Killing(str(lake), RULE, victim=victim), partitions=2).persist()
    rows, report = whyroad.spark.split(result)
    check_report(report.toArrow(), drives, {"broken": UNREADABLE["rule"], victim: "mine.drive.kills_worker"})
    expected = embedded(lake, "rule")
    same(rows.toArrow(), expected.filter(pa.compute.not_equal(expected["drive_id"], victim)))

    labels = spark.createDataFrame([("a", "{"), ("b", "{}")], "id string, label string")
    found = whyroad.spark.validate(labels, key="id").toArrow()
    assert set(found["id"].to_pylist()) == {"a", "b"}


def test_the_modules_are_thin() -> None:
    """Nothing of what a drive's work computes is in the modules of the engines."""
    for name in ("ray", "spark"):
        source = importlib.util.find_spec(f"whyroad.{name}")
        assert source is not None and source.origin is not None
        assert len(Path(source.origin).read_text(encoding="utf-8").splitlines()) < 200
