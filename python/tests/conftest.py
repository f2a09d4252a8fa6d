"""Fixtures: the bundled simulated drives, ingested, mined and built into a small release by the binary under test."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def binary() -> str:
    """The `whyroad` program: WHYROAD_BIN, or the release build of the repository."""
    return os.environ.get("WHYROAD_BIN", str(ROOT / "target/release/whyroad"))


def run(*args: str | Path) -> str:
    """Runs the program; exit code 1 (findings) is fine for the bundled drives."""
    done = subprocess.run([binary(), *map(str, args)], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that `whyroad demo` writes: lake, mined episodes, label drafts."""
    out = tmp_path_factory.mktemp("demo") / "demo"
    run("demo", "--out", out)
    return out


@pytest.fixture(scope="session")
def release(demo: Path) -> Path:
    """A release of drafts of the demo's episodes, with rendered bird's-eye images."""
    spec, out = demo / "spec.yaml", demo / "release"
    run("dataset", "init", spec)
    text = re.sub(r"(?m)^( *images:).*$", r"\1 bev", spec.read_text(encoding="utf-8"), count=1)
    spec.write_text(text, encoding="utf-8")
    run("dataset", "build", "--spec", spec, "--labels", demo / "mined", "--drafts", "--lake", demo / "lake", "--out", out)
    return out
