#!/usr/bin/env python3
"""Makes the simulations with known truth again: `python3 make.py [OUT_DIR]` (default: this folder).

Needs SUMO 1.28.0 (`pip install eclipse-sumo==1.28.0`). Two networks: a grid of four crossroads, two of them with lights, and a
motorway with an on-ramp. Traffic is drawn with a fixed seed. Beside what a log has (`fcd`, `net`, `tls`) the simulator's own
measures are kept: leader and gap (in `fcd`), lane changes, surrogate safety measures with their time series (`ssm`).
Outputs are stored without their dated comments, so that two runs give equal bytes.
"""

import gzip
import os
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import sumo

HERE = Path(__file__).resolve().parent
SEED = 20260103
# Only what happens around the egos is kept, m.
RADIUS_M = 90
# Looser than the simulator's defaults (3 s, 3 m/s2, 2 s), so that there is more to compare.
SSM_THRESHOLDS = "6.0 0.8 6.0"
FCD = "id,x,y,angle,type,speed,acceleration,lane,signals,leaderID,leaderSpeed,leaderGap"
EGOS = {
    "grid": "g18 g34 g36 g44 g53 g72".split(),
    "motorway": "m6 m10 m23 m27 m30 m40 m41".split(),
}
DURATION_S = {"grid": 90, "motorway": 55}


def tool(name, *args):
    subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", name), *map(str, args)], check=True, stdout=subprocess.DEVNULL)


def grid_network(net):
    tool("netgenerate", "--grid", "--grid.number", 2, "--grid.length", 140, "--grid.attach-length", 120,
         "--default.lanenumber", 2, "--default.speed", 13.89, "--tls.set", "A0,B1", "--tls.green.time", 14,
         "--no-turnarounds", "--output-file", net)


def motorway_network(net):
    source = HERE / "motorway" / "source"
    tool("netconvert", "--node-files", source / "nodes.nod.xml", "--edge-files", source / "edges.edg.xml",
         "--connection-files", source / "connections.con.xml", "--offset.disable-normalization",
         "--no-turnarounds", "--output-file", net)


def grid_demand(draw):
    """Trips between the eight ends of the grid, more than its crossroads take without conflicts."""
    arms = [("bottom", "A0"), ("bottom", "B0"), ("top", "A1"), ("top", "B1"),
            ("left", "A0"), ("left", "A1"), ("right", "B0"), ("right", "B1")]

    def end(side, node):
        return side + (node[1] if side in ("left", "right") else "01"["AB".index(node[0])])

    for i in range(90):
        (a, x), (b, y) = draw.sample(arms, 2)
        kind = draw.choices(["hasty", "calm", "lorry", "motorcycle"], [7, 2, 1, 1])[0]
        # Some stop in their lane for a while: a lead that brakes.
        stop = f'<stop lane="{end(a, x)}{x}_1" endPos="70" duration="6"/>' if i % 17 == 5 else ""
        yield f'<trip id="g{i}" type="{kind}" depart="{i * 0.9:.1f}" from="{end(a, x)}{x}" to="{y}{end(b, y)}" departLane="best" departSpeed="max">{stop}</trip>'


def motorway_demand(draw):
    for i in range(110):
        start = "ramp" if i % 3 == 0 else "before"
        kind = draw.choices(["hasty", "calm", "lorry", "motorcycle"], [6, 3, 2, 1])[0]
        # Now and then one crawls for a moment: a lead that brakes hard.
        stop = f'<stop lane="after_{i % 2}" endPos="{250 + i}" duration="5"/>' if i % 16 == 7 else ""
        yield f'<trip id="m{i}" type="{kind}" depart="{i * 0.45:.2f}" from="{start}" to="after" departLane="random" departSpeed="max">{stop}</trip>'


NETWORKS = {"grid": (grid_network, grid_demand), "motorway": (motorway_network, motorway_demand)}


def simulate(name, work):
    network, demand = NETWORKS[name]
    network(work / "net.xml")
    trips = "\n".join(demand(random.Random(SEED)))
    (work / "trips.xml").write_text(f"<routes>\n{trips}\n</routes>\n")
    lights = re.findall(r'<tlLogic id="([^"]+)"', (work / "net.xml").read_text())
    events = "".join(f'<timedEvent type="SaveTLSStates" source="{i}" dest="{work}/tls.xml"/>' for i in lights)
    (work / "lights.add.xml").write_text(f"<additional>{events}</additional>")
    egos = ",".join(EGOS[name])
    tool("sumo", "--net-file", work / "net.xml", "--route-files", f"{HERE / 'types.rou.xml'},{work / 'trips.xml'}",
         "--additional-files", work / "lights.add.xml", "--step-length", 0.1, "--end", DURATION_S[name], "--seed", SEED,
         # A lane change takes 3 s and moves the box sideways frame by frame.
         "--lanechange.duration", 3, "--time-to-teleport", -1, "--collision.action", "warn",
         "--fcd-output", work / "fcd.xml", "--fcd-output.attributes", FCD, "--fcd-output.max-leader-distance", 100,
         *(["--device.fcd.explicit", egos, "--device.fcd.radius", RADIUS_M] if egos else []),
         *(["--device.ssm.explicit", egos] if egos else ["--device.ssm.probability", 1]),
         "--device.ssm.file", work / "ssm.xml",
         "--device.ssm.measures", "TTC DRAC PET", "--device.ssm.thresholds", SSM_THRESHOLDS, "--device.ssm.range", 80,
         "--device.ssm.extratime", 5, "--device.ssm.trajectories", "true",
         "--lanechange-output", work / "lanechange.xml", "--lanechange-output.started", "--lanechange-output.ended",
         "--no-step-log", "--duration-log.disable")


def store(text_file, target):
    text = re.sub(r"<!--.*?-->\s*", "", text_file.read_text(), flags=re.S)
    # The series of positions and velocities are in `fcd` as well.
    text = re.sub(r"\s*<(?:egoPosition|egoLane|egoVelocity|foePosition|foeLane|foeVelocity|conflictPoint)\b[^>]*/>", "", text)
    with open(target, "wb") as raw, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0, compresslevel=9) as packed:
        packed.write(text.encode())


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for name in NETWORKS:
        target = out / name
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            work = Path(folder)
            simulate(name, work)
            for kind in ("net", "fcd", "lanechange", "tls", "ssm"):
                made = work / f"{kind}.xml"
                if made.exists():
                    store(made, target / f"{kind}.xml.gz")
        print(name, sum(f.stat().st_size for f in target.glob("*.gz")), "bytes")


if __name__ == "__main__":
    main()
