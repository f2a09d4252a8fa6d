#!/usr/bin/env python3
"""What the networks say of the road at each place of each ego: `python3 road.py` writes `road.csv.gz` beside each log.

Reads `net.xml.gz` and the lanes in `fcd.xml.gz` with the standard library alone: no part of Whyroad, and another reader than its own.
Every 0.5 s of simulated time in which an ego is on a lane outside junctions:

  lane               its id
  limit_mps          speed of the lane
  lanes              lanes of the edge that cars or buses may use
  to_end_m           from the front bumper along the lane to its end (the sum over the lane's polyline)
  junction           the edge's end joins three or more other nodes, and is not one where one-way roads only merge or part
  arms               how many other nodes it joins
  lights             it is a traffic_light
  turns              directions of the lane's connections, sorted: l, r, s, t
  exits              other nodes that the edge's connections lead to, not counting the one it comes from
  ramp               the edge leads into nothing but acceleration lanes
  left, right        neighbor for cars on that side in the same direction
"""

import csv
import gzip
import io
import math
import xml.etree.ElementTree as xml
from pathlib import Path

HERE = Path(__file__).resolve().parent
LOGS = {
    HERE / "grid": "g18 g34 g36 g44 g53 g72".split(),
    HERE / "motorway": "m6 m10 m23 m27 m30 m40 m41".split(),
    **{HERE.parent / "drives" / d: ["ego"] for d in ("back_street", "multilane", "signal_junction")},
}


def read(path):
    return xml.fromstring(gzip.decompress(path.read_bytes()))


def drivable(lane):
    allow, disallow = lane.get("allow", "").split(), lane.get("disallow", "").split()
    if allow:
        return "passenger" in allow or "bus" in allow
    return not {"passenger", "all"} <= set(disallow) and not ("passenger" in disallow and "bus" in disallow) and "all" not in disallow


def shape(text):
    return [tuple(map(float, p.split(",")[:2])) for p in text.split()]


def left_over(points, x, y):
    """Length of the polyline behind the foot point of (x, y)."""
    best, at, total = math.inf, 0.0, 0.0
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        length = math.dist((ax, ay), (bx, by))
        t = max(0.0, min(1.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2))
        away = math.dist((x, y), (ax + t * (bx - ax), ay + t * (by - ay)))
        if away < best:
            best, at = away, total + t * length
        total += length
    return total - at


def flows(before, after):
    """One-way roads that merge into one, or part from one. In these networks they do so at small angles."""
    return not before & after and min(len(before), len(after)) == 1


def table(folder, egos):
    net = read(folder / "net.xml.gz")
    edges = {e.get("id"): e for e in net.iter("edge") if not e.get("function")}
    lanes = {l.get("id"): (l, e) for e in edges.values() for l in e.iter("lane")}
    kinds = {j.get("id"): j.get("type") for j in net.iter("junction")}
    others, ins, outs = {}, {}, {}
    for e in edges.values():
        if e.find("lane") is not None:
            others.setdefault(e.get("from"), set()).add(e.get("to"))
            others.setdefault(e.get("to"), set()).add(e.get("from"))
            outs.setdefault(e.get("from"), set()).add(e.get("to"))
            ins.setdefault(e.get("to"), set()).add(e.get("from"))
    onward = {}
    for c in net.iter("connection"):
        if c.get("from") in edges and c.get("to") in edges:
            onward.setdefault(f"{c.get('from')}_{c.get('fromLane')}", []).append((c.get("dir").lower(), f"{c.get('to')}_{c.get('toLane')}"))
    fast = {i for i, (l, _) in lanes.items() if l.get("acceleration") == "1"}
    for step in read(folder / "fcd.xml.gz").iter("timestep"):
        time = float(step.get("time"))
        if abs(time * 2 - round(time * 2)) > 1e-6:
            continue
        for v in step.iter("vehicle"):
            if v.get("id") not in egos or v.get("lane") not in lanes:
                continue
            lane, edge = lanes[v.get("lane")]
            row = [l for l in edge.iter("lane") if drivable(l)]
            index = row.index(lane)
            all_next = [n for l in row for n in onward.get(l.get("id"), [])]
            end = edge.get("to")
            exits = {lanes[n][1].get("to") for _, n in all_next} - {edge.get("from")}
            is_ramp = bool(all_next) and all(n in fast for _, n in all_next) and not any(l.get("id") in fast for l in row)
            yield [
                v.get("id"), f"{time:.1f}", lane.get("id"), lane.get("speed"), len(row),
                f"{left_over(shape(lane.get('shape')), float(v.get('x')), float(v.get('y'))):.2f}",
                int(len(others[end]) >= 3 and not flows(ins.get(end, set()), outs.get(end, set()))), len(others[end]), int(kinds[end] == "traffic_light"),
                "".join(sorted({d for d, _ in onward.get(lane.get("id"), [])})), len(exits), int(is_ramp),
                # Lanes are numbered from the right.
                int(index + 1 < len(row)), int(index > 0),
            ]


def main():
    header = "ego,time_s,lane,limit_mps,lanes,to_end_m,junction,arms,lights,turns,exits,ramp,left,right".split(",")
    for folder, egos in LOGS.items():
        text = io.StringIO()
        out = csv.writer(text, lineterminator="\n")
        out.writerow(header)
        out.writerows(sorted(table(folder, egos), key=lambda r: (r[0], float(r[1]))))
        with open(folder / "road.csv.gz", "wb") as f, gzip.GzipFile("", "wb", 9, f, 0) as z:
            z.write(text.getvalue().encode())
        print(folder.name, text.getvalue().count("\n") - 1)


if __name__ == "__main__":
    main()
