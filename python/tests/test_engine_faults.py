"""Real processes of Ray and Spark are killed while they mine: the rows are those of the embedded run, each drive is
reported once, and a drive that kills its process is set aside and named."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import whyroad
from conftest import ROOT, run
from whyroad.per_drive import FAILURE, STATUS, portable

HERE = Path(__file__).parent
RULE = "target.gap < 40 m for 1 s"
DRIVES = 12
#: Dies on every attempt.
VICTIM = "d03"
#: A fault must be found and survived within this, s.
LONGEST = 480.0


@pytest.fixture(scope="session")
def lake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve drives."""
    out = tmp_path_factory.mktemp("faults") / "lake"
    names = ["back_street", "multilane", "signal_junction"]
    for i in range(DRIVES):
        drive = ROOT / "examples/drives" / names[i % 3]
        run("ingest", "sumo", drive, "--lake", out, "--drive-id", f"d{i:02}")
    return out


def missing(engine: str) -> str:
    """Why the engine cannot run here; empty when it can."""
    if importlib.util.find_spec("pyspark" if engine == "spark" else "ray") is None:
        return f"{engine} is not installed"
    if engine == "spark" and not (shutil.which("java") or os.environ.get("JAVA_HOME")):
        return "Spark needs Java"
    return ""


class Driver:
    """A driver process, and what it leaves behind."""

    def __init__(self, engine: str, lake: Path, folder: Path) -> None:
        if why := missing(engine):
            pytest.skip(why)
        self.marks, self.out = folder / "marks", folder / "out"
        self.marks.mkdir(exist_ok=True)
        paths = [str(HERE), *(p for p in sys.path if p)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
        command = [sys.executable, str(HERE / "engine_driver.py"), engine, str(lake), RULE]
        self.log = (folder / "log").open("a+", encoding="utf-8")
        self.process = subprocess.Popen(
            [*command, str(self.marks), str(self.out), VICTIM],
            env=environment,
            stdout=self.log,
            stderr=subprocess.STDOUT,
            cwd=folder,
            start_new_session=True,
        )

    def said(self) -> str:
        self.log.seek(0)
        return self.log.read()

    def wait_for(self, what: str, done: Callable[[], bool]) -> None:
        begun = time.monotonic()
        while not done():
            assert self.process.poll() is None, f"{what}: the driver ended\n{self.said()[-4000:]}"
            assert time.monotonic() - begun < LONGEST, f"{what}: not within {LONGEST} s\n{self.said()[-4000:]}"
            time.sleep(0.05)

    def begun(self) -> list[str]:
        """The drives that were begun, once for each time."""
        return [p.name.split(" ")[0] for p in self.marks.iterdir()]

    def at_work(self) -> dict[int, int]:
        """Processes of drives that are being worked on now, with their workers."""
        found = {}
        for mark in self.marks.iterdir():
            text = mark.read_text(encoding="utf-8").split()
            if len(text) == 2 and is_alive(int(text[0])):
                found[int(text[0])] = int(text[1])
        return found

    def finish(self) -> None:
        assert self.process.wait(LONGEST) == 0, self.said()[-4000:]

    def end(self) -> None:
        """Ends what this test has started: the process group of the driver, and no other."""
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        self.log.close()


def is_alive(pid: int) -> bool:
    return Path(f"/proc/{pid}/exe").exists()


def parent(pid: int) -> int:
    return int(Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[1])


@pytest.fixture
def start(lake: Path, tmp_path: Path) -> Iterator[Callable[[str], Driver]]:
    drivers: list[Driver] = []

    def one(engine: str) -> Driver:
        drivers.append(Driver(engine, lake, tmp_path))
        return drivers[-1]

    yield one
    for driver in drivers:
        driver.end()


def complete(lake: Path, out: Path) -> None:
    """The embedded rows, no more and no fewer; every drive once; the victim named."""
    opened = whyroad.open_lake(lake)
    others = [d for d in opened.drives() if d != VICTIM]
    keys = [(k, "ascending") for k in ("drive_id", "keyframe_ns", "scenario_id", "target_id", "episode_id")]
    expected = portable(pa.table(opened.mine(RULE, drives=others))).sort_by(keys)
    rows = pq.read_table(out / "rows").sort_by(keys)
    assert expected.num_rows > 0
    assert rows.cast(expected.schema).equals(expected)
    report = pq.read_table(out / "report").to_pylist()
    assert sorted(r["drive_id"] for r in report) == opened.drives()
    failed = {r["drive_id"]: r[FAILURE] for r in report if r[STATUS] == "failed"}
    assert failed.keys() == {VICTIM}
    assert "mine.drive.kills_worker" in failed[VICTIM]


def again(driver: Driver) -> list[str]:
    """Drives that were begun more than once, without the one that kills its process."""
    begun = driver.begun()
    return sorted({d for d in begun if begun.count(d) > 1 and d != VICTIM})


def test_a_killed_worker_of_ray(lake: Path, start: Callable[[str], Driver]) -> None:
    driver = start("ray")
    driver.wait_for("three drives begun", lambda: len(driver.begun()) >= 3 and bool(driver.at_work()))
    os.kill(next(iter(driver.at_work().values())), signal.SIGKILL)
    driver.finish()
    assert again(driver), "the kill hit no work"
    complete(lake, driver.out)


def test_a_killed_node_of_ray(lake: Path, start: Callable[[str], Driver]) -> None:
    driver = start("ray-nodes")
    lines = lambda: [s for s in driver.said().splitlines() if re.fullmatch(r"node( \d+)+", s)]  # noqa: E731
    driver.wait_for("the second node", lambda: bool(lines()))
    node = [int(pid) for pid in lines()[0].split()[1:]]

    def on_node() -> list[int]:
        """Workers of the second node that have a drive in work."""
        workers = [w for w in driver.at_work().values() if is_alive(w)]
        return [w for w in workers if parent(w) in node]

    driver.wait_for("work on the second node", lambda: bool(on_node()))
    # Its workers first: the raylet would start others.
    for pid in [*node, *on_node()]:
        if is_alive(pid):
            os.kill(pid, signal.SIGKILL)
    driver.finish()
    complete(lake, driver.out)


def test_a_killed_executor_of_spark(lake: Path, start: Callable[[str], Driver]) -> None:
    driver = start("spark")
    driver.wait_for("three drives begun", lambda: len(driver.begun()) >= 3 and bool(driver.at_work()))
    pid = next(iter(driver.at_work()))
    while "CoarseGrainedExecutorBackend" not in Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8"):
        pid = parent(pid)
        assert pid > 1, "the drive is not worked on below an executor"
    os.kill(pid, signal.SIGKILL)
    driver.finish()
    assert again(driver), "the kill hit no work"
    complete(lake, driver.out)


@pytest.mark.parametrize("engine", ["ray", "spark"])
def test_a_killed_driver_that_is_started_again(lake: Path, start: Callable[[str], Driver], engine: str) -> None:
    driver = start(engine)
    driver.wait_for("four drives begun", lambda: len(driver.begun()) >= 4)
    os.kill(driver.process.pid, signal.SIGKILL)
    driver.process.wait()
    assert not driver.out.exists(), "a killed driver publishes nothing"
    second = start(engine)
    second.finish()
    complete(lake, second.out)
