#!/usr/bin/env python3
"""Makes the drives with simulated truth: `python3 make.py [seen|unseen|both] [OUT_DIR]` (default: both, beside this file).

Needs `pip install eclipse-sumo==1.28.0`. The two sets come from the same scenes with other seeds, roads (curves, lane widths, numbers
of lanes) and speeds. `seen` is there to be looked at while rules are sharpened, `unseen` only to be reported. Two runs give equal bytes.
"""

import json
import random
import sys
import tempfile
from pathlib import Path

import crossing
import scenes
from leaves_crossing import CrossingLog
from log import Log
from stage import Motorway, Road, World, pack, types_file

HERE = Path(__file__).resolve().parent
SEEDS = {"seen": 20260201, "unseen": 77031}
# Cruising speeds m/s, lane widths m, curvature 1/m.
LAYOUT = {
    "seen": {"street": ([12.0, 13.5], [3.4, 3.5], 1 / 500), "avenue": ([13.0, 15.0], [3.4, 3.5], 1 / 700), "lane": ([8.5], [2.5], 1 / 400), "motorway": ([22.0], [3.75], 1 / 2500)},
    "unseen": {"street": ([11.0, 14.5], [3.3, 3.65], 1 / 380), "avenue": ([12.0, 17.0], [3.3, 3.6], 1 / 550), "lane": ([9.5], [2.45], 1 / 300), "motorway": ([25.0], [3.6], 1 / 1800)},
}
KINDS = {"street": (scenes.STREET, 1), "avenue": (scenes.AVENUE, 2), "lane": (scenes.LANE, 1), "motorway": (scenes.MOTORWAY, 3)}
# How often each scene of a kind is played in a set, and how many go into one drive.
TIMES = {"street": 3, "avenue": 3, "lane": 3, "motorway": 3}
PER_DRIVE = 13
# How often each scene of the crossroads is played.
CROSSINGS = 3


def bends(draw, length, curvature):
    """Straights and gentle curves to both sides."""
    out, s = [], 120.0
    while s < length:
        run = draw.uniform(60, 160)
        # Rounded as they are written down: what is read back must be the same road.
        out.append((round(s, 1), round(s + run, 1), round(draw.choice([-1, 1]) * curvature * draw.uniform(0.4, 1.0), 7)))
        s += run + draw.uniform(100, 300)
    return out


def play(kind, chosen, cruise, width, curvature, seed):
    draw = random.Random(seed)
    lanes = KINDS[kind][1]
    # The road is made long enough for any course of the scenes and cut to what was driven.
    curves = bends(draw, 12000, curvature)
    road = Motorway(12000, width, curves) if kind == "motorway" else Road(12000, lanes, width, curves)
    world = World(road, cruise, draw)
    if kind == "motorway":
        world.ego.d = road.lane(1)
    for _ in range(60):
        world.step()
    for scene in chosen:
        world.note("scene", name=scene.__name__)
        world.wish, world.forced, world.blind = cruise, None, set()
        run = scene(world)
        limit = world.t + 160
        for _ in run:
            world.step()
            if world.t > limit:
                raise RuntimeError(f"{scene.__name__} does not end")
        world.wish, world.forced = cruise, None
        for _ in range(int(draw.uniform(30, 45))):
            world.step()
    road.length = int(world.ego.s / 10 + 12) * 10
    return world


def make(which, out):
    draw = random.Random(SEEDS[which])
    total = 0
    out.mkdir(parents=True, exist_ok=True)
    (out / "types.rou.xml").write_text(types_file())
    for kind, (pool, _) in KINDS.items():
        speeds, widths, curvature = LAYOUT[which][kind]
        todo = [s for s in pool for _ in range(TIMES[kind])]
        draw.shuffle(todo)
        for i in range(0, len(todo), PER_DRIVE):
            name = f"{which}_{kind}_{i // PER_DRIVE:02}"
            cruise, width = draw.choice(speeds) * draw.uniform(0.95, 1.05), draw.choice(widths)
            world = play(kind, todo[i:i + PER_DRIVE], cruise, width, curvature, draw.randrange(10**6))
            folder = out / name
            folder.mkdir(exist_ok=True)
            with tempfile.TemporaryDirectory() as tmp:
                world.road.write(Path(tmp), round(cruise * 1.2, 2))
                net = (Path(tmp) / "net.xml").read_text()
            net = net[net.index("<net "):].replace("    <junction", "".join(world.road.marks()) + "    <junction", 1)
            pack(folder / "net.xml.gz", net)
            world.write(folder)
            road = {"length": world.road.length, "lanes": world.road.lanes, "width": width, "cruise": round(cruise, 2), "bends": world.road.bends}
            road["bends"] = [b for b in road["bends"] if b[0] < road["length"]]
            road["ramps"] = getattr(world.road, "ramps", [])
            road["crosswalks"] = world.road.crosswalks
            script = {"road": road, "houses": world.buildings, "works": world.works, "events": world.events}
            pack(folder / "script.json.gz", json.dumps(script))
            if touched := Log(folder).contacts():
                raise RuntimeError(f"{name}: not as it was meant: {touched}")
            size = sum(f.stat().st_size for f in folder.glob("*"))
            total += size
            print(name, f"{world.t:.0f} s, {size // 1024} kB", flush=True)
    print(which, total // 1024, "kB")


def make_crossings(which, out):
    """One scene a drive, each on a crossroads turned another way."""
    draw = random.Random(SEEDS[which] + 1)
    todo = [scene for scene in crossing.SCENES for _ in range(CROSSINGS)]
    total = 0
    for n, scene in enumerate(todo):
        name = f"{which}_crossing_{n:02}"
        lanes = 2 if scene is crossing.turn_abreast else 1
        width = 3.1 if lanes == 2 else draw.choice([3.25, 3.5] if which == "seen" else [3.3, 3.65])
        world = crossing.Crossing(lanes, width, draw.uniform(0, 6.28), random.Random(draw.randrange(10**6)))
        world.note("scene", name=scene.__name__)
        for _ in scene(world):
            world.step()
            if world.t > 60:
                raise RuntimeError(f"{scene.__name__} does not end")
        folder = out / name
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory() as tmp:
            world.write_net(Path(tmp))
            net = (Path(tmp) / "net.xml").read_text()
        pack(folder / "net.xml.gz", net[net.index("<net "):])
        world.write(folder)
        pack(folder / "script.json.gz", json.dumps({"events": world.events}))
        if touched := CrossingLog(folder).contacts():
            raise RuntimeError(f"{name}: not as it was meant: {touched}")
        total += sum(f.stat().st_size for f in folder.glob("*"))
    print(f"{which} crossings", total // 1024, "kB")


def main():
    which = sys.argv[1] if len(sys.argv) > 1 else "both"
    out = Path(sys.argv[2]) if len(sys.argv) > 2 else HERE
    for name in SEEDS:
        if which in (name, "both"):
            make(name, out / name)
            make_crossings(name, out / name)


if __name__ == "__main__":
    main()
