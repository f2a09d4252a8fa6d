#!/usr/bin/env python3
"""Generates the trial's drives with known truth: `python3 make.py GROUP OUT_DIR [NETWORK ...]`, GROUP being develop,
varied, held or held2 to held19.

Needs SUMO 1.28.0 (`pip install eclipse-sumo==1.28.0`). `develop` may be looked at while rules are changed; `held` has
other networks, drivers and steps, and is evaluated once (docs/explanation/accuracy-simulated.md says when). Nothing
generated is committed: `manifest.txt` has the SHA-256 of each file, and `make.py check OUT_DIR` compares. Each run:
fcd, net, tls, egos.txt, truth.jsonl.
"""

import gzip
import hashlib
import math
import os
import random
import re
import sys
import tempfile
from pathlib import Path

import sumo

sys.path.append(os.path.join(sumo.SUMO_HOME, "tools"))
import sumolib  # noqa: E402

import judge  # noqa: E402
from demand import trips, types  # noqa: E402
from groups import NOISE, SETS  # noqa: E402
from networks import document, tool  # noqa: E402

HERE = Path(__file__).resolve().parent
FCD = "id,x,y,z,angle,type,speed,pos,acceleration,lane,edge,signals,leaderID,leaderSpeed,leaderGap"
EGOS = {f"held{n}": 42 for n in range(10, 20)}
RADIUS_M = 120


def build(maker, draw, work):
    options = maker(work, draw)
    # Roads "as drawn" have the ends of their shapes; others are led on to the middle of their nodes.
    whole = ["--plain.extend-edge-shape"] if "as drawn" not in options else []
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml",
         *(["--connection-files", work / "con.xml"] if (work / "con.xml").exists() else []),
         "--output-file", work / "net.xml", "--offset.disable-normalization", *whole, *(o for o in options if o != "as drawn"))


def simulate(work, draw, seed, seconds, step, model, lateral, rate, people, count):
    net = sumolib.net.readNet(str(work / "net.xml"))
    rows, egos = trips(draw, net, model, seconds, rate, people, count)
    # Cars that are parked all along stand there first.
    still = (work / "parked.txt").read_text().splitlines() if (work / "parked.txt").exists() else []
    document(work / "trips.xml", "routes", types(model, lateral) + still + rows)
    lights = re.findall(r'<tlLogic id="([^"]+)"', (work / "net.xml").read_text())
    document(work / "lights.add.xml", "additional", [f'<timedEvent type="SaveTLSStates" source="{i}" dest="{work}/tls.xml"/>' for i in lights])
    names = ",".join(egos)
    tool("sumo", "--net-file", work / "net.xml", "--route-files", work / "trips.xml", "--additional-files", ",".join(str(f) for f in sorted(work.glob("*.add.xml"))),
         "--step-length", step, "--end", seconds, "--seed", seed, *(["--lateral-resolution", 0.8] if lateral == "sublane" else ["--lanechange.duration", lateral]),
         "--time-to-teleport", -1, "--collision.action", "warn", "--collision.check-junctions", "--ignore-route-errors", "--pedestrian.model", "striping",
         "--fcd-output", work / "fcd.xml", "--fcd-output.attributes", FCD, "--fcd-output.max-leader-distance", 120,
         "--device.fcd.explicit", names, "--device.fcd.radius", RADIUS_M,
         "--device.ssm.explicit", names, "--device.ssm.file", work / "ssm.xml", "--device.ssm.measures", "TTC DRAC PET", "--device.ssm.thresholds", "2.2 99 1.6",
         "--device.ssm.range", 60, "--device.ssm.extratime", 3, "--lanechange-output", work / "lanechange.xml", "--collision-output", work / "collisions.xml",
         "--no-step-log", "--duration-log.disable", "--no-warnings")
    return egos


def store(text, target):
    with open(target, "wb") as raw, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0, compresslevel=9) as packed:
        packed.write(re.sub(r"<!--.*?-->\s*", "", text, flags=re.S).encode())


def leveled(text, net):
    """Heights by the lanes' shapes: SUMO 1.28 lets a vehicle sink by meters while it changes into the oncoming lane."""
    lanes = {m.group(1): [tuple(map(float, p.split(","))) for p in m.group(2).split()] for m in re.finditer(r'<lane id="([^"]*)"[^>]*? shape="([^"]*)"', net)}

    def height(points, x, y):
        nearest, at = math.inf, 0.0
        for (ax, ay, *az), (bx, by, *bz) in zip(points, points[1:]):
            long = (bx - ax) ** 2 + (by - ay) ** 2
            t = max(0.0, min(1.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / long)) if long else 0.0
            away = (ax + t * (bx - ax) - x) ** 2 + (ay + t * (by - ay) - y) ** 2
            if away < nearest:
                nearest, at = away, (az or [0.0])[0] * (1 - t) + (bz or [0.0])[0] * t
        return at

    def row(m):
        value = lambda name: re.search(rf' {name}="([^"]*)"', m.group(0)).group(1)
        points = lanes.get(value("lane"))
        return re.sub(r' z="[^"]*"', f' z="{height(points, float(value("x")), float(value("y"))):.2f}"', m.group(0)) if points else m.group(0)

    return re.sub(r"<vehicle [^>]*>", row, text)


def noisy(text, draw, step, white, slow, speed, turn, lost):
    """Positions and speeds of all vehicles as a sensor gives them; accelerations are not measured. The deviation that
    lasts 1 s is an autoregressive one for each vehicle.
    """
    keep, drift = math.exp(-step), {}

    def measured(m):
        name, row = m.group(2), m.group(0)
        if lost and not name.startswith("ego") and draw.random() < lost:
            return ""
        old = drift.get(name, (draw.gauss(0, slow), draw.gauss(0, slow)))
        drift[name] = tuple(keep * d + math.sqrt(1 - keep**2) * draw.gauss(0, slow) for d in old)
        x, y = (drift[name][i] + draw.gauss(0, white) for i in (0, 1))
        moved = lambda attribute, more: lambda v: f' {attribute}="{max(0.0, float(v.group(1)) + more) if attribute == "speed" else float(v.group(1)) + more:.2f}"'
        for attribute, more in (("x", x), ("y", y)):
            row = re.sub(rf' {attribute}="([^"]*)"', moved(attribute, more), row)
        fast = re.search(r' speed="([^"]*)"', row)
        if fast and float(fast.group(1)) > 0.5:
            row = re.sub(r' speed="([^"]*)"', moved("speed", draw.gauss(0, speed)), row)
        if turn:
            row = re.sub(r' angle="([^"]*)"', lambda v: f' angle="{(float(v.group(1)) + draw.gauss(0, turn)) % 360:.2f}"', row)
        return re.sub(r' acceleration="[^"]*"', "", row)

    return re.sub(r'<(vehicle|person) id="([^"]*)"[^>]*>', measured, text)


def generate(group, out, only):
    for name, (maker, seed, seconds, step, model, lateral, rate, people) in SETS[group].items():
        if only and name not in only:
            continue
        target = out / group / name
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            work, draw = Path(folder), random.Random(seed)
            build(maker, draw, work)
            egos = simulate(work, draw, seed, seconds, step, model, lateral, rate, people, EGOS.get(group, 24))
            egos, lines = judge.derive(work, name, egos, lateral)
            text, net = (work / "fcd.xml").read_text(), (work / "net.xml").read_text()
            if "<neigh " in net:
                text = leveled(text, net)
            # The leader, lane and reasons are the simulator's knowledge, not a recording's.
            text = re.sub(r' (?:leaderID|leaderSpeed|leaderGap|lane|edge|pos)="[^"]*"', "", text)
            noise = NOISE.get(f"{group}/{name}", NOISE.get(group))
            if noise:
                text = noisy(text, random.Random(seed + 1), step, *noise)
            store(text, target / "fcd.xml.gz")
            for kind in ("net", "tls"):
                if (work / f"{kind}.xml").exists():
                    store((work / f"{kind}.xml").read_text(), target / f"{kind}.xml.gz")
            document(target / "trial.rou.xml", "routes", types(model, lateral))
        (target / "truth.jsonl").write_text("\n".join(lines) + "\n")
        (target / "egos.txt").write_text(" ".join(egos) + "\n")
        print(group, name, len(egos), "egos", len(lines) - 1, "entries", sum(f.stat().st_size for f in target.iterdir()), "bytes", flush=True)


def sums(out):
    """By path: what `generate` writes, and nothing that `measure` leaves beside it."""
    kinds = ("*.xml.gz", "*.rou.xml", "truth.jsonl", "egos.txt")
    found = sorted(f for group in SETS for kind in kinds for f in (out / group).glob(f"*/{kind}"))
    return {f.relative_to(out).as_posix(): hashlib.sha256(f.read_bytes()).hexdigest() for f in found}


def main():
    match sys.argv[1:]:
        case [group, out, *only] if group in SETS:
            generate(group, Path(out), only)
        case ["record", out]:
            (HERE / "manifest.txt").write_text("# eclipse-sumo 1.28.0\n" + "".join(f"{v} {k}\n" for k, v in sums(Path(out)).items()))
        case ["check", out]:
            lines = [line.split(" ", 1) for line in (HERE / "manifest.txt").read_text().splitlines() if not line.startswith("#")]
            faults = sorted({v: k for k, v in lines}.items() ^ sums(Path(out)).items())
            print(*faults, f"{len(lines)} files, {len(faults)} faults", sep="\n")
            return 1 if faults or not lines else 0
        case _:
            sys.exit(__doc__)
    return 0


if __name__ == "__main__":
    sys.exit(main())
