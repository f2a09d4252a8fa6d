#!/usr/bin/env python3
"""Makes the bundled drives again: `python3 make.py [OUT_DIR]` (default: this folder).

Needs SUMO 1.28.0 (`pip install eclipse-sumo==1.28.0`). For each drive the network is built from its
hand-written sources, the simulation is stepped with its script (what cars and people are told to do,
and when), and the outputs are stored without their dated comments, so that two runs give equal bytes.
"""

import gzip
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import sumo

sys.path.insert(0, os.path.join(sumo.SUMO_HOME, "tools"))
import traci  # noqa: E402  (comes with SUMO)

import scripts  # noqa: E402  (beside this file)

HERE = Path(__file__).resolve().parent
STEP_S = 0.1
# Vehicles farther from the ego than this are not in the log, as with a real sensor.
RANGE_M = 120

# Name of the drive: how long it lasts in seconds, and what happens at each step.
DRIVES = {
    "signal_junction": (62.0, scripts.signal_junction),
    "multilane": (64.0, scripts.multilane),
    "back_street": (48.0, scripts.back_street),
}


def run_tool(name, *args):
    subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", name), *args], check=True, stdout=subprocess.DEVNULL)


def build_network(source, net):
    run_tool(
        "netconvert",
        "--node-files", str(source / "nodes.nod.xml"),
        "--edge-files", str(source / "edges.edg.xml"),
        "--connection-files", str(source / "connections.con.xml"),
        "--output-file", str(net),
        "--no-turnarounds",
        "--offset.disable-normalization",
        "--junctions.corner-detail", "5",
        "--junctions.limit-turn-speed", "5.5",
    )


def simulate(name, source, work, duration_s, script):
    additional = []
    lights = source / "lights.add.xml"
    if lights.exists():
        filled = work / "lights.add.xml"
        filled.write_text(lights.read_text().replace("@OUT@", str(work)))
        additional = ["--additional-files", str(filled)]
    traci.start([
        os.path.join(sumo.SUMO_HOME, "bin", "sumo"),
        "--net-file", str(work / "net.xml"),
        "--route-files", f"{HERE / 'types.rou.xml'},{source / 'demand.rou.xml'}",
        *additional,
        "--step-length", str(STEP_S),
        "--seed", "20260101",
        "--pedestrian.model", "striping",
        # A lane change takes 3 s and moves the box sideways frame by frame.
        "--lanechange.duration", "3",
        "--fcd-output", str(work / "fcd.xml"),
        "--fcd-output.acceleration",
        "--fcd-output.signals",
        "--device.fcd.explicit", "ego",
        "--device.fcd.radius", str(RANGE_M),
        "--lanechange-output", str(work / "lanechange.xml"),
        "--lanechange-output.started",
        "--lanechange-output.ended",
        "--collision-output", str(work / "collisions.xml"),
        "--collision.action", "warn",
        "--no-step-log",
        "--duration-log.disable",
    ])
    state = {}
    try:
        for step in range(int(round(duration_s / STEP_S))):
            script(traci, round(step * STEP_S, 1), state)
            traci.simulationStep()
    finally:
        traci.close()


def store(text_file, target):
    """Compresses `text_file` without the comments in which SUMO writes the date and its options."""
    text = re.sub(r"<!--.*?-->\s*", "", text_file.read_text(), flags=re.S)
    with open(target, "wb") as raw, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0) as packed:
        packed.write(text.encode())


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for name, (duration_s, script) in DRIVES.items():
        source = HERE / name / "source"
        target = out / name
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            work = Path(folder)
            build_network(source, work / "net.xml")
            simulate(name, source, work, duration_s, script)
            for kind in ("net", "fcd", "lanechange", "tls"):
                made = work / f"{kind}.xml"
                if made.exists():
                    store(made, target / f"{kind}.xml.gz")
            if "<collision " in (work / "collisions.xml").read_text():
                sys.exit(f"{name}: a collision happened; the drive is not what it is meant to be")
        print(name, sum(f.stat().st_size for f in target.glob("*.gz")), "bytes")


if __name__ == "__main__":
    main()
