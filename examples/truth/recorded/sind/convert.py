#!/usr/bin/env python3
"""Drives in whyroad's table layout from OnSite scenes: SinD (Tianjin) and SECTION.

    python3 convert.py OUT --egos FILE --map map_relink_law_save.osm --scenes onsite-test-server/scenes \\
        onsite-structured-test/scenario/replay
    whyroad ingest table OUT/sind --map OUT/sind.osm --map-origin 0,0 --lake lake
    whyroad ingest table OUT/section_junction --map intersection_12_61_4.xodr --lake lake
    whyroad ingest table OUT/section_crossing --map crossing_752_7_0.xodr --lake lake

FILE names one drive per line, as in `drives` of the truth file here. Read are:

- 600 fragments of SinD (Tsinghua University, not for commercial purposes) as OpenSCENARIO, `8_2_1_130_exam.xosc`, with
  the colors of a light beside them, `8_2_1_130.json`: github.com/yangyh408/onsite-test-server, folder `scenes`, where
  the same fragment is in several folders. Fragment 8_2_1_130 is part of the recording 8_2_1.
- Two scenes named SECTION, one file each: github.com/yangyh408/onsite-structured-test, folder `scenario/replay`.
- SinD's Lanelet2 map: github.com/SOTIF-AVLab/SinD, `Data/Tianjin/map_relink_law_save.osm`.

None of them is part of this project. Each scene hides one car, the ego of the competition. In SinD, the fragments of a
recording are joined to stretches, as a vehicle has exactly the same length and width in each fragment. A stretch has
the name of its first fragment, in alphabetical order: in sind_tj_8_2_1_143_v06, 8_2_1_143 is that fragment and v06 the
seventh vehicle, ordered by length. The drive is cut to the longest time in which at least two fragments cover each
step, so that no car is hidden. In SECTION, the hidden car is missing.

What the data do not have is left out: bicycles, motorcycles, tricycles and pedestrians of SinD, lights of SECTION,
velocities, heights, turn signals and dates (time 0 is 1970-01-01T00:00:00Z). A car longer than 7 m becomes
large_vehicle.

Lights of SinD: two groups, 26 s green, 3 s yellow, 1 s all red (SinD's `TrafficLight_8_2_1.csv`). Where this cycle fits
at least 97 % of the stated colors, it is used; where several phases fit, the color is unknown at the times at which
they differ. Otherwise only the stated colors are used, and red for a group while the crossing one is green or yellow. A
light may change up to 1.2 s earlier than written: OnSite took SinD's frames for 0.1 s instead of 0.1001 s. Needs numpy.
"""

import argparse
import csv
import json
import math
import re
import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np

SECTION = {"section_crossing": "crossing_752_7_0", "section_junction": "intersection_12_61_4_4340"}
KINDS = {"car": "car", "bicycle": "bicyclist", "motorbike": "motorcyclist", "pedestrian": "pedestrian"}
LARGE_M = 7.0
# Two tracks are the same passage where they are this close to each other, at this speed or more.
SAME_M, MOVING_MPS = 0.05, 1.0
# Offsets in time of one pair of fragments: samples needed, and how far 90 % of them may be from their median.
OFFSETS, OFFSET_S = 5, 0.06
# OnSite interpolated headings through 0 where they pass 2 pi: a larger step begins such a fault, a smaller one ends it.
FAULT_RAD, FAULT_ENDS_RAD, FAULT_STEPS = 0.8, 0.5, 7
CYCLE_S, GREEN_S, YELLOW_S = 60, 26, 3
# When each group turns green, in s of the cycle, and the group that crosses it.
GREEN_AT_S = {"NS": 0, "EW": 30}
CROSSING = {"NS": "EW", "EW": "NS"}
# Least share of the stated colors that the cycle has to fit, and by how much other phases may be worse than the best.
CYCLE_FITS, PHASE_FITS = 0.97, 0.005
STOP_LINE_M = 1.5
# SinD's map is in degrees around 0, 0.
METRES_PER_DEGREE = np.array([111319.49, 110574.4])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--egos", type=Path, required=True, help="file with one drive per line")
    parser.add_argument("--map", type=Path, required=True, help="SinD's map of Tianjin")
    parser.add_argument("--scenes", type=Path, nargs="+", required=True, help="folders that have the scenes")
    options = parser.parse_args()
    drives = options.egos.read_text(encoding="utf-8").split()
    paths = {}
    for folder in options.scenes:
        for path in sorted(folder.rglob("*_exam.xosc")):
            paths.setdefault(path.name.removesuffix("_exam.xosc"), path)

    options.out.mkdir(parents=True, exist_ok=True)
    groups = write_map(options.map, options.out / "sind.osm")
    recordings = defaultdict(list)
    for drive in drives:
        scene = drive.rsplit("_", 1)[0]
        name = SECTION.get(scene) or scene.removeprefix("sind_tj_")
        if name not in paths:
            raise SystemExit(f"{drive}: no {name}_exam.xosc in the folders of --scenes; --help names its repository")
        if scene in SECTION:
            write_section(options.out / scene / drive, scene, read_scene(paths[name])["tracks"])
        else:
            recordings[name.rsplit("_", 1)[0]].append((drive, name))
    for recording, named in recordings.items():
        fragments = {name: read_scene(path) for name, path in paths.items() if re.fullmatch(rf"{recording}_\d+", name)}
        stretches = join(fragments)
        for drive, fragment in named:
            starts = next(stretch for stretch in stretches if fragment in stretch)
            write_sind(options.out / "sind" / drive, recording, fragments, starts, groups)


def read_scene(path):
    """Tracks by name, the heading at which the hidden car begins, end of the scene in s, and colors of its light."""
    text = path.read_text(encoding="utf-8")
    root = ElementTree.fromstring(text)
    tracks = {}
    for group in root.iter("ManeuverGroup"):
        rows = [
            [float(vertex.get("time")), *(float(vertex.find(".//WorldPosition").get(key)) for key in "xyh")]
            for vertex in group.iter("Vertex")
        ]
        if rows:
            name = group.find(".//EntityRef").get("entityRef")
            actor = root.find(f"Entities/ScenarioObject[@name='{name}']")[0]
            size = actor.find("BoundingBox/Dimensions")
            length, width = float(size.get("length")), float(size.get("width"))
            category = "pedestrian" if actor.tag == "Pedestrian" else actor.get("vehicleCategory")
            tracks[name] = track(KINDS[category], length, width, np.array(rows))
    lights = path.with_name(path.name.replace("_exam.xosc", ".json"))
    return {
        "tracks": tracks,
        "heading": float(re.search(r"heading_init = (-?[\d.]+(?:e-?\d+)?)", text)[1]),
        "end": float(root.find("Storyboard/StopTrigger//SimulationTimeCondition").get("value")),
        "lights": json.loads(lights.read_text()) if lights.exists() else {},
    }


def track(kind, length, width, rows):
    """A track from rows of time in s, place and heading."""
    kind = "large_vehicle" if kind == "car" and length > LARGE_M else kind
    return {"class": kind, "length": length, "width": width, "t": rows[:, 0], "place": rows[:, 1:3], "h": rows[:, 3]}


def size_of(vehicle):
    return round(vehicle["length"], 6), round(vehicle["width"], 6)


def join(fragments):
    """Stretches of one recording: for each, the starts of its fragments in s, from the first that was read."""
    by_size = {name: {size_of(v): v for v in scene["tracks"].values()} for name, scene in fragments.items()}
    neighbors = defaultdict(list)
    names = list(fragments)
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            shared = set(by_size[a]) & set(by_size[b])
            found = [offset for size in shared for offset in offsets(by_size[a][size], by_size[b][size])]
            if len(found) >= OFFSETS:
                middle = np.median(found)
                if np.percentile(np.abs(np.array(found) - middle), 90) < OFFSET_S:
                    neighbors[a].append((b, middle))
                    neighbors[b].append((a, -middle))
    stretches = []
    for name in names:
        if any(name in stretch for stretch in stretches):
            continue
        starts, pending = {name: 0.0}, [name]
        while pending:
            a = pending.pop()
            for b, offset in neighbors[a]:
                if b not in starts:
                    starts[b] = starts[a] + offset
                    pending.append(b)
        stretches.append(starts)
    return stretches


def offsets(a, b):
    """Time in a minus time in b wherever the vehicle, while it moves, is at the same place in both, in s."""
    if len(a["t"]) < 3:
        return
    speed = np.hypot(*np.gradient(a["place"], axis=0).T) / 0.1
    for i in np.flatnonzero(speed > MOVING_MPS):
        nearest = int(np.hypot(*(b["place"] - a["place"][i]).T).argmin())
        on_b = []
        for k in range(max(nearest - 1, 0), min(nearest + 1, len(b["t"]) - 1)):
            step = b["place"][k + 1] - b["place"][k]
            if step @ step >= 1e-4:
                share = np.clip((a["place"][i] - b["place"][k]) @ step / (step @ step), 0, 1)
                gap = np.hypot(*(b["place"][k] + share * step - a["place"][i]))
                on_b.append((gap, b["t"][k] + share * (b["t"][k + 1] - b["t"][k])))
        if on_b and min(on_b)[0] < SAME_M:
            yield a["t"][i] - min(on_b)[1]


def joined_tracks(fragments, starts):
    """Tracks of a stretch by id, at steps of 0.1 s."""
    rows = defaultdict(dict)
    for name, start in starts.items():
        for vehicle in fragments[name]["tracks"].values():
            for t, place, heading in zip(vehicle["t"], vehicle["place"], vehicle["h"]):
                step = round((t + start) * 10)
                rows[size_of(vehicle)].setdefault(step, [step / 10, *place, heading])
    ids = {size: f"v{k:02d}" for k, size in enumerate(sorted(rows))}
    tracks = {}
    for size, steps in rows.items():
        tracks[ids[size]] = track("car", *size, np.array([steps[t] for t in sorted(steps)]))
        tracks[ids[size]]["h"] = corrected(tracks[ids[size]]["h"])
    return tracks


def corrected(headings):
    """Headings without those that OnSite interpolated through 0: interpolated between both sides the short way."""
    h = np.unwrap(headings)
    i = 1
    while i < len(h):
        if abs(math.remainder(h[i] - h[i - 1], math.tau)) > FAULT_RAD:
            for j in range(i + 1, min(i + 1 + FAULT_STEPS, len(h))):
                turn = math.remainder(h[j] - h[i - 1], math.tau)
                if abs(turn) < FAULT_ENDS_RAD:
                    h[i:j] = h[i - 1] + turn * np.arange(1, j - i + 1) / (j - i + 1)
                    i = j
                    break
        i += 1
    return h


def ego_of(drive, tracks):
    ego = drive.rsplit("_", 1)[1]
    if ego not in tracks:
        raise SystemExit(f"{drive}: no vehicle {ego} in its scene; it has {', '.join(sorted(tracks))}")
    return ego


def write_section(folder, scene, tracks):
    ego = ego_of(folder.name, tracks)
    first, last = tracks[ego]["t"][[0, -1]]
    write_drive(folder, f"source: onsite-{scene}", tracks, ego, first, last, decimals=2)


def write_sind(folder, recording, fragments, starts, groups):
    tracks = joined_tracks(fragments, starts)
    ego = ego_of(folder.name, tracks)
    covered = Counter()
    for name, start in starts.items():
        seen = max(round(vehicle["t"][-1] * 10) for vehicle in fragments[name]["tracks"].values())
        steps = min(int(fragments[name]["end"] * 10), seen) + 1
        covered.update(range(round(start * 10), round(start * 10) + steps))
    steps = np.array([step for step in np.round(tracks[ego]["t"] * 10).astype(int) if covered[step] >= 2])
    longest = max(np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1), key=len).tolist()
    if len(longest) < 2:
        raise SystemExit(f"{folder.name}: two fragments never cover the same time of {ego}; choose another vehicle")
    first, last = longest[0], longest[-1]
    source = f"source: sind-tianjin-{recording}\nplace: Tianjin"
    write_drive(folder, source, tracks, ego, first / 10, last / 10, decimals=1)

    color_at = colors(fragments, starts)
    rows = []
    for group in CROSSING:
        shown = None
        for step in range(first, last + 1):
            color = color_at(group, step)
            if color != shown:
                rows += [[(step - first) / 10, lane, color] for lane, of in groups.items() if of == group]
            shown = color
    write_table(folder / "lights.csv", ["time_s", "lane_id", "colour"], sorted(rows, key=lambda row: row[0]))


def colors(fragments, starts):
    """A function of group and step of 0.1 s: the color of this group of lights."""
    stated = [
        (start + float(t), "EW" if abs(math.cos(fragments[name]["heading"])) > 0.7 else "NS", color)
        for name, start in starts.items()
        for t, color in fragments[name]["lights"].items()
    ]
    times = np.array([time for time, _, _ in stated])
    green_at = np.array([GREEN_AT_S[group] for _, group, _ in stated])
    shown = np.array([color for _, _, color in stated])
    fits = {phase: np.mean(cycle(times - phase - green_at) == shown) for phase in np.arange(0, CYCLE_S, 0.1)}
    best = max(fits.values())
    if best >= CYCLE_FITS and len(set(shown)) > 1:
        phases = np.array([phase for phase, fit in fits.items() if fit >= best - PHASE_FITS])

        def of_cycle(group, step):
            in_cycle = (step / 10 - phases) % CYCLE_S
            found = set(cycle(in_cycle - GREEN_AT_S[group]).tolist())
            return found.pop() if len(found) == 1 else "unknown"

        return of_cycle
    samples = defaultdict(set)
    for time, group, color in stated:
        samples[group, round(time * 10)].add(color)

    def of_samples(group, step):
        own, crossing = samples[group, step], samples[CROSSING[group], step]
        crossed = len(crossing) == 1 and crossing <= {"green", "yellow"}
        if not own:
            return "red" if crossed else "unknown"
        contradiction = len(own) > 1 or (crossed and own <= {"green", "yellow"})
        return "unknown" if contradiction else min(own)

    return of_samples


def cycle(since_green):
    """Colors at these times in s since the group turned green."""
    t = since_green % CYCLE_S
    return np.where(t < GREEN_S, "green", np.where(t < GREEN_S + YELLOW_S, "yellow", "red"))


def write_drive(folder, source, tracks, ego_name, first, last, decimals):
    """The ego and the other tracks from first to last, in s."""
    folder.mkdir(parents=True, exist_ok=True)

    def states(vehicle):
        for t, (x, y), heading in zip(vehicle["t"], vehicle["place"], vehicle["h"]):
            if first - 1e-6 <= t <= last + 1e-6:
                heading = math.remainder(heading, math.tau)
                yield f"{t - first:.{decimals}f}", [f"{x:.3f}", f"{y:.3f}", f"{heading:.4f}"]

    ego = tracks[ego_name]
    write_table(
        folder / "ego.csv", ["time_s", "x_m", "y_m", "heading_rad"], ([time, *pose] for time, pose in states(ego))
    )
    write_table(
        folder / "objects.csv",
        ["time_s", "track_id", "class", "x_m", "y_m", "heading_rad", "length_m", "width_m"],
        (
            [time, name, vehicle["class"], *pose, f"{vehicle['length']:.2f}", f"{vehicle['width']:.2f}"]
            for name, vehicle in tracks.items()
            if name != ego_name
            for time, pose in states(vehicle)
        ),
    )
    (folder / "drive.yaml").write_text(
        f"""drive_id: {folder.name}
{source}
start_time: 1970-01-01T00:00:00Z
ego:
  reference_to_centre_m: 0
  length_m: {ego["length"]:.2f}
  width_m: {ego["width"]:.2f}
""",
        encoding="utf-8",
    )
    print(folder.name)


def write_table(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def write_map(source, target):
    """Writes SinD's map with what it lacks; returns the lanes that end at a stop line with their group of lights.

    It lacks the subtype of the lanelets in the junction, and the reference of the other lanelets to their light.
    """
    tree = ElementTree.parse(source)
    root = tree.getroot()
    nodes = {
        node.get("id"): np.array([float(node.get("lon")), float(node.get("lat"))]) * METRES_PER_DEGREE
        for node in root.iter("node")
    }
    ways = {way.get("id"): np.array([nodes[nd.get("ref")] for nd in way.iter("nd")]) for way in root.iter("way")}
    stop_lines = [ways[way.get("id")] for way in root.iter("way") if tags(way).get("type") == "stop_line"]
    lights = {
        relation.get("id"): ways[relation.find("member[@role='ref_line']").get("ref")].mean(0)
        for relation in root.iter("relation")
        if tags(relation).get("type") == "regulatory_element"
    }
    groups = {}
    for relation in root.iter("relation"):
        found = tags(relation)
        if found.get("type") != "lanelet" or found.get("subtype") == "crosswalk":
            continue
        left, right = (ways[relation.find(f"member[@role='{side}']").get("ref")] for side in ("left", "right"))
        begin, end = ends(left, right)
        if min(distance(end, line) for line in stop_lines) < STOP_LINE_M:
            groups[relation.get("id")] = "EW" if np.argmax(np.abs(end - begin)) == 0 else "NS"
            bounds = np.vstack([left, right])
            light = min(lights, key=lambda light: np.hypot(*(bounds - lights[light]).T).min())
            member = ElementTree.Element("member", type="relation", ref=light, role="regulatory_element")
            relation.insert(0, member)
        if "subtype" not in found:
            for key, value in (("subtype", "road"), ("location", "urban"), ("one_way", "yes")):
                ElementTree.SubElement(relation, "tag", k=key, v=value)
    tree.write(target)
    return groups


def tags(element):
    return {tag.get("k"): tag.get("v") for tag in element.iter("tag")}


def ends(left, right):
    """Middle of a lanelet's begin and end; each bound is turned so that the left one is on the left."""
    turned = []
    for a in (left, left[::-1]):
        for b in (right, right[::-1]):
            (vx, vy), (wx, wy) = a[-1] - a[0] + b[-1] - b[0], b[0] - a[0]
            if vx * wy - vy * wx < 0:
                apart = np.hypot(*(a[0] - b[0])) + np.hypot(*(a[-1] - b[-1]))
                turned.append((apart, (a[0] + b[0]) / 2, (a[-1] + b[-1]) / 2))
    return min(turned, key=lambda pair: pair[0])[1:]


def distance(point, line):
    steps = np.diff(line, axis=0)
    share = np.clip(((point - line[:-1]) * steps).sum(1) / np.maximum((steps**2).sum(1), 1e-9), 0, 1)
    return np.hypot(*(point - line[:-1] - share[:, None] * steps).T).min()


if __name__ == "__main__":
    main()
