#!/usr/bin/env python3
"""Generates the simulated drives with known truth, and checks them against `manifest.txt`.

    python3 sets.py generate DIR     all sets of agents, roads and traffic, below DIR
    python3 sets.py check DIR        every generated file against the manifest; exit code 1 on any difference
    python3 sets.py record DIR       write the manifest (after a change of a script)
    python3 sets.py sample           the committed sample against the manifest; needs no SUMO

The manifest has one line per file: SHA-256, size, path. Its first line pins the SUMO version, because another version
gives other drives. Only the sample (`SAMPLE`) is committed; the rest is reproduced byte for byte by the scripts.
"""

import hashlib
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
MANIFEST = HERE / "manifest.txt"
SUMO = "1.28.0"
PARTS = ["agents", "roads", "traffic"]
# Drives that tests read in every run: crates/whyroad/tests/it/truth.rs, tests of the fast evaluator, web/e2e.
SAMPLE = [
    *(f"agents/seen/seen_{d}" for d in (
        "avenue_00", "avenue_01", "avenue_03", "crossing_03", "crossing_04", "crossing_11", "crossing_19", "crossing_27",
        "lane_01", "motorway_00", "street_01", "street_05")),
    "agents/unseen/unseen_crossing_17",
    *(f"roads/seen/seen-{d}" for d in (
        "approach00", "approach03", "junction00", "junction01", "lane02", "light01", "road05", "road06", "road14", "shape06",
        "yard02")),
    "traffic/seen-motorway",
    "traffic/seen-ring",
]


def in_sample(path):
    """Files of the drives of the sample, and the files of a set that belong to no single drive."""
    return any(path.startswith(f"{drive}/") for drive in SAMPLE) or path in (
        "agents/seen/types.rou.xml", "agents/unseen/types.rou.xml", "roads/seen/truth.jsonl")


def files(root):
    """Generated files below `root`, by path; scripts and pages are not generated."""
    found = {}
    for part in PARTS:
        for path in sorted((root / part).rglob("*")):
            name = path.relative_to(root).as_posix()
            generated = name.count("/") >= 2 and "__pycache__" not in name
            if path.is_file() and generated:
                found[name] = path
    return found


def line(path, name):
    data = path.read_bytes()
    return f"{hashlib.sha256(data).hexdigest()} {len(data):>8} {name}"


def manifest():
    lines = MANIFEST.read_text().splitlines()
    return {text.split(" ")[-1]: text for text in lines if text and not text.startswith("#")}


def generate(out):
    import sumo  # noqa: F401, PLC0415

    version = subprocess.run([f"{sumo.SUMO_HOME}/bin/sumo", "--version"], capture_output=True, text=True, check=True).stdout
    if SUMO not in version.splitlines()[0]:
        sys.exit(f"SUMO {SUMO} is needed (pip install eclipse-sumo=={SUMO}); this is: {version.splitlines()[0]}")
    for folder, arguments in (
        ("agents", ["make.py", "both", out / "agents"]),
        ("agents", ["truth.py", out / "agents" / "seen", out / "agents" / "unseen"]),
        ("roads", ["make.py", out / "roads"]),
        ("traffic", ["make.py", "all", out / "traffic"]),
    ):
        (out / folder).mkdir(parents=True, exist_ok=True)
        print("==", folder, arguments[0], flush=True)
        subprocess.run([sys.executable, *map(str, arguments)], cwd=HERE / folder, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)


def compare(found, expected):
    faults = [f"missing: {name}" for name in sorted(expected.keys() - found.keys())]
    faults += [f"not in the manifest: {name}" for name in sorted(found.keys() - expected.keys())]
    faults += [f"differs: {name}" for name in sorted(found.keys() & expected.keys()) if line(found[name], name) != expected[name]]
    for fault in faults:
        print(fault)
    print(f"{len(found)} files, {len(faults)} faults")
    return 1 if faults or not found else 0


def main():
    match sys.argv[1:]:
        case ["generate", out]:
            generate(Path(out).resolve())
        case ["check", out]:
            return compare(files(Path(out)), manifest())
        case ["record", out]:
            rows = [line(path, name) for name, path in files(Path(out)).items()]
            MANIFEST.write_text(f"# eclipse-sumo {SUMO}; written by sets.py record\n" + "".join(f"{r}\n" for r in rows))
            print(len(rows), "files")
        case ["sample"]:
            expected = {name: text for name, text in manifest().items() if in_sample(name)}
            return compare(files(HERE), expected)
        case _:
            sys.exit(__doc__)
    return 0


if __name__ == "__main__":
    sys.exit(main())
