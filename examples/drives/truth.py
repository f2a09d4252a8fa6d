#!/usr/bin/env python3
"""What happens in the bundled drives, from the simulator's outputs alone: writes `truth.jsonl` beside each drive.

Nothing here comes from Whyroad's signals or rules. Used: positions and lanes (FCD), lane changes with their
reasons (lanechange output), what turns lanes make and where crossings are (network), sizes (types). Keyframes
follow LABELING.md 4. The first line names the classes for which the list is complete in that drive; classes in
which judgment is needed (was it a response?) are listed where they are plain, and are not called complete.
"""

import gzip
import json
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

HERE = Path(__file__).resolve().parent
START_NS = 1_767_225_600 * 10**9  # 2026-01-01T00:00:00Z, where `ingest sumo` puts zero
LANE_M = 3.2


def read(drive, kind):
    with gzip.open(HERE / drive / f"{kind}.xml.gz") as f:
        return ET.fromstring(f.read())


class Simulation:
    def __init__(self, drive):
        self.drive = drive
        self.times, self.at = [], {}
        for step in read(drive, "fcd"):
            t = round(float(step.get("time")), 1)
            self.times.append(t)
            for o in step:
                self.at[t, o.get("id")] = {
                    "x": float(o.get("x")), "y": float(o.get("y")), "speed": float(o.get("speed")),
                    "angle": float(o.get("angle")), "lane": o.get("lane") or o.get("edge"),
                    "type": o.get("type"), "person": o.tag == "person", "signals": int(o.get("signals") or 0),
                }
        net = read(drive, "net")
        self.turn = {c.get("via"): c.get("dir") for c in net.iter("connection") if c.get("via")}
        self.link = {c.get("via"): (c.get("tl"), int(c.get("linkIndex") or -1)) for c in net.iter("connection") if c.get("via")}
        self.lights = []
        if (HERE / drive / "tls.xml.gz").exists():
            self.lights = [(float(s.get("time")), s.get("id"), s.get("state")) for s in read(drive, "tls")]
        # A joint of two roads is no junction: nothing else comes in.
        self.real = {j.get("id") for j in net.iter("junction") if len({l.rsplit("_", 1)[0] for l in j.get("incLanes").split()
                                                                       if not l.startswith(":")}) > 1}
        types = ET.parse(HERE / "types.rou.xml").getroot()
        self.size = {v.get("id"): (float(v.get("length")), float(v.get("width"))) for v in types}
        self.ids = sorted({i for _, i in self.at})

    def light(self, lane, t):
        """State of the light for what enters the junction over this lane, or "" where there is none."""
        of, link = self.link[lane]
        states = [s for u, i, s in self.lights if i == of and u <= t]
        return states[-1][link] if states else ""

    def series(self, name):
        return [(t, self.at[t, name]) for t in self.times if (t, name) in self.at]

    def record(self, leaf, start, keyframe, end, target=None):
        ns = lambda t: START_NS + round(max(0.0, min(t, self.times[-1])) * 10) * 10**8
        out = {"scenario_id": leaf, "drive_id": f"{self.drive}-ego", "start_ns": ns(start), "keyframe_ns": ns(keyframe), "end_ns": ns(end)}
        return out | ({"target_id": target} if target else {})


def turns(sim):
    """Traversals of real junctions; the turn is the network's own. A left turn on "G" has its own right of way; on "g" it is
    unprotected, and an interaction, not a turn, where somebody comes through from opposite within 5 s."""
    kinds = {"s": "straight", "l": "left_normal", "r": "right_normal"}
    run = []
    for t, o in sim.series("ego") + [(None, {"lane": ""})]:
        inside = o["lane"].startswith(":") and o["lane"][1:].rsplit("_", 2)[0] in sim.real
        if inside:
            run.append((t, o))
        elif run:
            entry, out = run[0][0], run[-1][0] + 0.1
            kind = kinds[sim.turn[run[0][1]["lane"]]]
            if kind == "left_normal" and sim.light(run[0][1]["lane"], entry) != "G":
                kind, heading = "left_unprotected", run[0][1]["angle"]
                near = {o["lane"]: (o, i) for (t, i), o in sim.at.items() if abs(t - entry) < 5 and i != "ego" and not o["person"]}
                junction = run[0][1]["lane"][1:].rsplit("_", 2)[0]
                if any(o["lane"].startswith(f":{junction}_") and sim.turn.get(o["lane"]) in ("s", "r")
                       and abs((o["angle"] - heading) % 360 - 180) < 45 for o, _ in near.values()):
                    run = []
                    continue
            keyframe = entry
            if kind != "straight":
                before = run[0][1]["angle"]
                keyframe = next(t for t, o in run if abs((o["angle"] - before + 180) % 360 - 180) > 1) - 0.5
            yield sim.record(f"proactive.turn.{kind}", entry - 3, keyframe, out + 2)
            run = []


def intention(sim, t, indicator):
    """When the ego formed the intention to change lane (LABELING.md 4, row lane_change): its indicator (bit of SUMO's `signals`) went on, and
    stayed on until it moved; at most a clip ago, at the latest where the motion begins: 1.5 s before SUMO logs the change, which takes 3 s.
    Where it did not indicate by then, the default of the L1: 2 s before it has moved 0.3 m.
    """
    first = round(t - 1.5, 1)
    on = next((u for u in sim.times if first <= u < t and sim.at[u, "ego"]["signals"] & indicator), None)
    if on is None:
        return round(first + math.ceil(30 * 0.3 / LANE_M) / 10 - 2, 1)
    while on > first - 20 and (u := round(on - 0.1, 1), "ego") in sim.at and sim.at[u, "ego"]["signals"] & indicator:
        on = u
    return min(on, first)


def is_passed(me, other):
    """The ego's front is beyond the other's, beside it (TAXONOMY.md, lane_change.overtake); places are those of fronts."""
    ahead, right = math.radians(me["angle"]), math.radians(me["angle"] + 90)
    dx, dy = other["x"] - me["x"], other["y"] - me["y"]
    return dx * math.sin(ahead) + dy * math.cos(ahead) < 0 and abs(dx * math.sin(right) + dy * math.cos(right)) < 8


def lane_changes(sim):
    """The ego's own, and others' into its lane in front of it. On the straights of these networks y is lateral."""
    for c in read(sim.drive, "lanechange"):
        t, name = round(float(c.get("time")), 1), c.get("id")
        if name == "ego":
            start = intention(sim, t, 2 if c.get("dir") == "1" else 1)
            # "strategic" is for the route. "speedGain" overtakes whom it passes, or else only gains speed.
            leaf = {"strategic": "navigation", "speedGain": "efficiency"}[c.get("reason").split("|")[0]]
            old, me = c.get("from"), sim.at[t, "ego"]
            ahead = [(o["x"] - me["x"], i) for i in sim.ids if (o := sim.at.get((t - 2, i))) and o["lane"] == old and o["x"] > me["x"]]
            if leaf == "efficiency" and any((o := sim.at.get((u, min(ahead)[1]))) and (u, "ego") in sim.at and is_passed(sim.at[u, "ego"], o)
                                            for u in sim.times if t < u < t + 20):
                leaf = "overtake"
            yield sim.record(f"proactive.lane_change.{leaf}", start, start, t + 1.5)
            continue
        me, it = sim.at[t, "ego"], sim.at.get((t, name))
        if it is None or c.get("to") != me["lane"] or not 0 < it["x"] - me["x"] < 60:
            continue
        length, width = sim.size[it["type"]]
        line = lambda o: LANE_M / 2 - (abs(o["y"] - me["y"]) - width / 2)  # over the ego's line when positive
        keyframe = next(u for u in sim.times if u > t - 3 and (u, name) in sim.at and line(sim.at[u, name]) > 0)
        a, b = sim.at[keyframe, "ego"], sim.at[keyframe, name]
        closing = a["speed"] - b["speed"]
        ttc = (b["x"] - length - a["x"]) / closing if closing > 0 else math.inf
        leaf = "large_vehicle" if it["type"] == "truck" else "urgent" if ttc < 3 else "slow"
        end = next(u for u in sim.times if u > keyframe and abs(sim.at[u, name]["y"] - me["y"]) < 0.5)
        yield sim.record(f"reactive_agent.cutin.{leaf}", keyframe - (2 if leaf == "urgent" else 5), keyframe, end, name)


def vehicles_on_way(sim, way, k0):
    """Distance from the ego's way and arc length ahead on it, of all other vehicles when the ego is at its point k0."""
    t = sim.times[k0]
    for o in (sim.at.get((t, i)) for i in sim.ids if i != "ego"):
        if o and not o["person"]:
            k = min(range(k0, len(way)), key=lambda k: math.hypot(way[k][0] - o["x"], way[k][1] - o["y"]))
            off = math.hypot(way[k][0] - o["x"], way[k][1] - o["y"])
            yield off, sum(math.dist(way[i], way[i + 1]) for i in range(k0, k))


def crossings(sim):
    """People who cross the ego's driven way within 50 m in front of it while it slows or stands for them.

    Not those before whom another vehicle stands on that way: then that vehicle is the proximate cause (LABELING.md 6).
    """
    ego = sim.series("ego")
    way = [(o["x"], o["y"]) for _, o in ego]
    for name in (i for i in sim.ids if any(o["person"] for _, o in sim.series(i)[:1])):
        rows = []
        for t, o in sim.series(name):
            # Nearest point of the way still ahead of the ego, and the side of it.
            k0 = next(k for k, (u, _) in enumerate(ego) if u == t)
            k = min(range(k0, len(way)), key=lambda k: math.hypot(way[k][0] - o["x"], way[k][1] - o["y"]))
            n = min(k + 3, len(way) - 1)
            dx, dy = way[n][0] - way[k][0], way[n][1] - way[k][1]
            off = math.hypot(way[k][0] - o["x"], way[k][1] - o["y"])
            side = dx * (o["y"] - way[k][1]) - dy * (o["x"] - way[k][0])
            ahead = sum(math.dist(way[i], way[i + 1]) for i in range(k0, k))
            rows.append((t, math.copysign(off, side), ahead, o))
        over = [b for a, b in zip(rows, rows[1:]) if a[1] * b[1] < 0 and abs(b[1]) < 1 and 1 < b[2] < 50]
        if not over or min(o["speed"] for t, o in ego if abs(t - over[0][0]) < 4) > 5:
            continue
        t0, _, arc, person = over[0]
        if any(d < 1.5 and 1 < s < arc for d, s in vehicles_on_way(sim, way, next(k for k, (u, _) in enumerate(ego) if u == t0))):
            continue
        near = [r for r in rows if r[0] <= t0 and abs(r[1]) < 7 and r[2] < 50]
        start = near[-1][0]
        for r in reversed(near):
            if start - r[0] > 0.15:
                break
            start = r[0]
        later = [r for r in rows if r[0] > t0 and abs(r[1]) > 1.5]
        if re.fullmatch(r":.*_c\d+(_\d+)?", person["lane"]):
            leaf = "crosswalk"
        else:
            angle = abs((person["angle"] - sim.at[t0, "ego"]["angle"] + 90) % 180 - 90)
            leaf = "horizontal" if angle > 60 else "diagonal"
        yield sim.record(f"reactive_agent.vru_crossing.{leaf}", start, start, later[0][0], name)


def queue(sim):
    """Stopping behind a standing car in the same lane, and starting after it.

    A car that brakes at 3 m/s2 or more for 0.5 s is lead_sudden_brake whether or not the ego stops (taxonomy): from then on.
    """
    ego, lead = sim.series("ego"), None
    standing = [t for t, o in ego if o["speed"] < 0.3]
    for t in standing[:1]:
        me = sim.at[t, "ego"]
        ahead = [(o["x"] - me["x"], i) for i in sim.ids if (o := sim.at.get((t, i))) and i != "ego" and not o["person"]
                 and o["lane"] == me["lane"] and 0 < o["x"] - me["x"] < 15 and o["speed"] < 0.1]
        if not ahead:
            return
        lead = min(ahead)[1]
        stops = next(u for u, o in sim.series(lead) if u > 5 and o["speed"] < 0.3)
        speed = {u: o["speed"] for u, o in sim.series(lead)}
        hard = [u for u in speed if stops - 6 < u < stops and speed[u] - speed.get(round(u + 0.5, 1), speed[u]) >= 3 * 0.5]
        if hard:
            yield sim.record("reactive_agent.following.lead_sudden_brake", hard[0] - 2, hard[0], hard[0] + 3, lead)
        else:
            yield sim.record("reactive_agent.following.follow_stop", stops - 2, stops, t, lead)
        starts = next(u for u, o in sim.series(lead) if u > t and o["speed"] > 0.3)
        yield sim.record("reactive_agent.following.follow_start", starts - 2, starts, starts + 3, lead)


def bends(sim):
    """The bend of the multi-lane road: from 0.5 s before the ego slows for it until it has left it."""
    inside = [t for t, o in sim.series("ego") if o["lane"].startswith("bend")]
    if inside:
        slowing = inside[0]
        while sim.at[round(slowing - 0.1, 1), "ego"]["speed"] > sim.at[slowing, "ego"]["speed"]:
            slowing = round(slowing - 0.1, 1)
        yield sim.record("reactive_road.geometry_adaptation.high_curvature", slowing - 0.5, slowing - 0.5, inside[-1])


COMPLETE = [f"reactive_agent.cutin.{v}" for v in ("urgent", "large_vehicle")] + [
    *(f"proactive.lane_change.{v}" for v in ("navigation", "efficiency", "overtake")),
    *(f"proactive.turn.{v}" for v in ("straight", "left_normal", "left_unprotected", "right_normal")),
    "reactive_agent.following.follow_start", "reactive_agent.following.follow_stop",
    "reactive_agent.vru_crossing.horizontal", "reactive_agent.vru_crossing.diagonal",
    "reactive_road.geometry_adaptation.high_curvature",
]


def main():
    for drive in ("back_street", "multilane", "signal_junction"):
        sim = Simulation(drive)
        found = [r for part in (turns, lane_changes, crossings, queue, bends) for r in part(sim)]
        found.sort(key=lambda r: (r["keyframe_ns"], r["scenario_id"]))
        head = {"complete": COMPLETE, "drives": [f"{drive}-ego"]}
        lines = [json.dumps(x) for x in [head, *found]]
        (HERE / drive / "truth.jsonl").write_text("\n".join(lines) + "\n")
        for r in found:
            print(drive, r["scenario_id"], r.get("target_id", "-"), *(round((r[k] - START_NS) / 1e9, 1) for k in ("start_ns", "keyframe_ns", "end_ns")))


if __name__ == "__main__":
    main()
