"""Fixtures: the bundled simulated drives, ingested, mined and built into a small release by the binary under test."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def binary() -> str:
    """The `whyroad` program: WHYROAD_BIN, or the release build of the repository."""
    return os.environ.get("WHYROAD_BIN", str(ROOT / "target/release/whyroad"))


def run(*args: str | Path, codes: tuple[int, ...] = (0, 1)) -> str:
    """Runs the program; exit code 1 (findings) is fine for the bundled drives."""
    done = subprocess.run([binary(), *map(str, args)], capture_output=True, text=True, check=False)
    assert done.returncode in codes, f"{args}: {done.returncode} {done.stderr}"
    return done.stdout


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that `whyroad demo` writes: lake, mined episodes, label drafts, release. WHYROAD_DEMO names one."""
    if made := os.environ.get("WHYROAD_DEMO"):
        return Path(made)
    out = tmp_path_factory.mktemp("demo") / "demo"
    run("demo", "--out", out)
    return out


@pytest.fixture(scope="session")
def release(demo: Path) -> Path:
    """The release of drafts that the demo builds, with rendered bird's-eye images."""
    return demo / "release"


def pytest_sessionfinish(session: pytest.Session) -> None:
    """What is required fails instead of being skipped."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    skipped = reporter.stats.get("skipped", []) if reporter else []
    if skipped and "python" in os.environ.get("WHYROAD_REQUIRE", "").split(","):
        reporter.write_line(f"WHYROAD_REQUIRE=python: {len(skipped)} tests were skipped", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
