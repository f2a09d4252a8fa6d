#!/usr/bin/env python3
"""Makes the traffic sets again: `python3 make.py [seen|unseen|second|fresh|all] [OUT_DIR [NETWORK ...]]` (default: all, this folder).

Needs SUMO 1.28.0 (`pip install eclipse-sumo==1.28.0`). For each network of `networks.py` the traffic of `demand.py` is simulated; what a
recording has (positions around the egos, network, lights) is kept, and `truth.jsonl` is derived by `truth.py` from everything that the
simulator says. Outputs are stored without their dated comments, so that two runs give equal bytes.
"""

import gzip
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import sumo

import truth
from demand import DEMANDS, SECONDS
from networks import NETWORKS, document

HERE = Path(__file__).resolve().parent
SEEDS = {"seen": 20260301, "unseen": 88117, "second": 415926, "fresh": 7350918}
# What happens farther than this from every ego is not in the log, m.
RADIUS_M = 60
FCD = "id,x,y,z,angle,type,speed,pos,acceleration,lane,edge,signals,leaderID,leaderSpeed,leaderGap"


def tool(name, *args):
    subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", name), *map(str, args)], check=True, stdout=subprocess.DEVNULL)


def build(name, variant, work):
    nodes, edges, links, options = NETWORKS[name](variant)
    for kind, tag, rows in (("nod", "nodes", nodes), ("edg", "edges", edges), ("con", "connections", links)):
        (work / f"{kind}.xml").write_text(document(tag, rows))
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml", *(["--connection-files", work / "con.xml"] if links else []),
         "--output-file", work / "net.xml", "--no-turnarounds", "--offset.disable-normalization", "--junctions.corner-detail", 5,
         "--junctions.limit-turn-speed", 5.5, *options)


def simulate(name, seed, work):
    rows = sorted(DEMANDS[name](random.Random(seed), SECONDS[name]))
    (work / "trips.xml").write_text(document("routes", [r for _, r in rows]))
    egos = sorted(set(re.findall(r'<trip id="(ego\w*)"', "".join(r for _, r in rows))))
    lights = re.findall(r'<tlLogic id="([^"]+)"', (work / "net.xml").read_text())
    events = "".join(f'<timedEvent type="SaveTLSStates" source="{i}" dest="{work}/tls.xml"/>' for i in lights)
    (work / "lights.add.xml").write_text(f"<additional>{events}</additional>")
    tool("sumo", "--net-file", work / "net.xml", "--route-files", f"{HERE / 'types.rou.xml'},{work / 'trips.xml'}",
         "--additional-files", work / "lights.add.xml", "--step-length", 0.1, "--end", SECONDS[name], "--seed", seed,
         # A lane change takes 3 s and moves the box sideways frame by frame.
         "--lanechange.duration", 3, "--time-to-teleport", -1, "--collision.action", "warn", "--collision.check-junctions", "true",
         "--pedestrian.model", "striping",
         "--fcd-output", work / "fcd.xml", "--fcd-output.attributes", FCD, "--fcd-output.max-leader-distance", 100,
         "--device.fcd.explicit", ",".join(egos), "--device.fcd.radius", RADIUS_M,
         "--device.ssm.explicit", ",".join(egos), "--device.ssm.file", work / "ssm.xml", "--device.ssm.measures", "TTC DRAC PET",
         "--device.ssm.thresholds", "1.5 99 1.0", "--device.ssm.range", 60, "--device.ssm.extratime", 3,
         "--lanechange-output", work / "lanechange.xml", "--lanechange-output.started", "--lanechange-output.ended",
         "--collision-output", work / "collisions.xml", "--no-step-log", "--duration-log.disable", "--no-warnings")
    return egos


def store(text, target):
    with open(target, "wb") as raw, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0, compresslevel=9) as packed:
        packed.write(re.sub(r"<!--.*?-->\s*", "", text, flags=re.S).encode())


def main():
    which = sys.argv[1] if len(sys.argv) > 1 else "all"
    out = Path(sys.argv[2]) if len(sys.argv) > 2 else HERE
    only = sys.argv[3:] or list(NETWORKS)
    if out.resolve() != HERE:
        # The sizes of vehicles, which ingestion looks for beside the drives: without them every box is unknown.
        out.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(HERE / "types.rou.xml", out / "types.rou.xml")
    for variant, group in enumerate(SEEDS):
        for name in only if which in (group, "all") else []:
            target = out / f"{group}-{name}"
            target.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory() as folder:
                work = Path(folder)
                build(name, variant, work)
                egos = simulate(name, SEEDS[group], work)
                text = (work / "fcd.xml").read_text()
                # The leader is the simulator's knowledge, not the recording's.
                store(re.sub(r' (?:leaderID|leaderSpeed|leaderGap|lane|edge|pos)="[^"]*"', "", text), target / "fcd.xml.gz")
                for kind in ("net", "tls"):
                    if (work / f"{kind}.xml").exists():
                        store((work / f"{kind}.xml").read_text(), target / f"{kind}.xml.gz")
                lines = truth.derive(work, target.name, egos)
                (target / "truth.jsonl").write_text("\n".join(lines) + "\n")
                (target / "egos.txt").write_text(" ".join(egos) + "\n")
            print(target.name, len(egos), "egos", len(lines) - 1, "entries", sum(f.stat().st_size for f in target.iterdir()), "bytes")


if __name__ == "__main__":
    main()
