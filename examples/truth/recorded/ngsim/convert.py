"""Drives in whyroad's table layout from NGSIM recordings: US-101 (Los Angeles) and I-80 (Emeryville).

NGSIM (FHWA, 2005-06) has vehicles at 10 Hz from cameras on high buildings. The recordings have no recording vehicle:
each chosen vehicle becomes the ego of one drive, all others are its objects. Positions, speeds and headings are
written as the files have them, nothing is smoothed.

    convert.py us101 --scenarios DIR --out drives/us101 --egos 23 --lively 14
    convert.py i80 --tracks i80.csv --out drives/i80 --egos 5

us101: CommonRoad scenarios (XML, TU Munich, made from NGSIM and OpenStreetMap), 8 to 17 s each. Scenarios of one
recording overlap: they share vehicles with the same headings and speeds digit for digit. `SEQUENCES` lists the
scenarios that were found to belong together; the shift in time and place between two of them is computed here from
the shared tracks, and a difference of more than 1 cm anywhere is an error. Joined they give up to 22 s of one
vehicle. A vehicle that no scenario holds at a time is not there at that time, so objects can appear and vanish in
the middle of the road. Positions are box centers (as the format defines). All are `car` in the scenarios; longer
than 7 m becomes large_vehicle. Lanes, lines and where the ramps join are those of the scenarios' lanelets, joined
lane by lane (`SEQUENCES` names them): five lanes from the left, on-ramp, auxiliary lane, off-ramp. Tags ramp,
acceleration and deceleration are set here from that shape. The scenarios have no date: time 0 of the sequences is
set to 07:50, 07:52 and 07:54 PDT of 2005-06-15, the day of the US-101 recordings.

i80: a table of car-following pairs (CSV of R_workshop_materials_NGSIM_data's df.parquet): raw tracks of 30 to 74 s in
lanes 1 to 3, metric. Only the vehicles of the table are known, most others on the road are missing. Positions are
front centers in the file (Local_X from the left edge, Local_Y along the road) and are moved back by half a length.
x is Local_Y, y is -Local_X, headings are those of the road (0), as the file has none. Lanes are the known geometry:
six lanes of 12 ft from the left edge, lane 1 for high occupancy; the file has no on-ramp. Lines: dashed between
lanes, solid at the left edge, unknown at the right edge. Egos are followers whose leader has own rows (its Local_X)
for 12 s and more; the drive is cut to these. Time is the frame number from 2005-04-13 16:00 PDT, the nominal start.

Both: drives are cut to 40 s around their middle. Egos are drawn in the order of SHA-256 of their drive ids; one that
follows or leads a drawn ego nose to tail for half of its time is passed over. When too few of the drawn egos change
lane or get a new vehicle in front of them by its lane change (`lively`), the last drawn others are replaced by the
next that do.
"""

import argparse
import csv
import hashlib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

FOOT = 0.3048
LARGE_M = 7.0
STEP_S = 0.1
HEADER = ["heading_rad", "speed_mps"]
KINDS = {"car": "car", "truck": "truck", "bus": "bus", "motorcycle": "motorcycle"}

# Scenario with its lanelets of lanes 1 to 5 and of the ramp or auxiliary lane, for each of three sections in driving
# direction (before the on-ramp joins, beside the auxiliary lane, after it). Several pieces of a section are joined.
SEQUENCES = {
    "a": {
        "scenarios": ["24_1", "14_1", "23_1", "13_1"],
        "start": "2005-06-15T14:50:00Z",
        "sections": [
            [("13_1", None)],
            [("23_1", [120, 46, 123, 50, 52, 124])],
            [("23_1", [121, 13, 11, 9, 7, 29])],
        ],
    },
    "b": {
        "scenarios": ["15_1", "5_1", "3_1", "28_1", "9_1", "25_1", "20_1"],
        "start": "2005-06-15T14:52:00Z",
        "sections": [
            [("5_1", [31, 43, 29, 27, 25, None]), ("25_1", [25, 42, 21, 18, 15, 12])],
            [("25_1", [23, 40, 20, 17, 14, 11]), ("9_1", [31, 33, 35, 37, 39, 23])],
            [("9_1", [29, 27, 26, 25, 24, 22])],
        ],
    },
    "c": {
        "scenarios": ["21_1", "22_1"],
        "start": "2005-06-15T14:54:00Z",
        "sections": [
            [("21_1", [30, 42, 26, 23, 20, 17])],
            [("22_1", [44, 46, 48, 50, 52, 20])],
            [("22_1", [42, 28, 26, 24, 22, 19])],
        ],
    },
}


def number(element, path):
    found = element.find(path)
    return float(found.findtext("exact", found.text))


def read_scenario(path):
    """Tracks {id: {kind, length, width, rows: {step: (x, y, heading, speed)}}} and lanelets {id: (left, right)}."""
    root = ElementTree.parse(path).getroot()
    tracks = {}
    for obstacle in root.iter("dynamicObstacle"):
        rows = {}
        for state in [obstacle.find("initialState"), *obstacle.findall("trajectory/state")]:
            place = (number(state, "position/point/x"), number(state, "position/point/y"))
            rows[round(number(state, "time"))] = (*place, number(state, "orientation"), number(state, "velocity"))
        length = float(obstacle.findtext("shape/rectangle/length"))
        tracks[int(obstacle.get("id"))] = {
            "kind": "large_vehicle" if length > LARGE_M else KINDS.get(obstacle.findtext("type"), "vehicle"),
            "length": length,
            "width": float(obstacle.findtext("shape/rectangle/width")),
            "rows": rows,
        }
    lanelets = {}
    for lanelet in root.iter("lanelet"):
        sides = []
        for side in ("leftBound", "rightBound"):
            points = lanelet.findall(f"{side}/point")
            line = np.array([[float(point.findtext("x")), float(point.findtext("y"))] for point in points])
            sides.append((line, lanelet.findtext(f"{side}/lineMarking")))
        right = lanelet.find("adjacentRight")
        after = [int(item.get("ref")) for item in lanelet.findall("successor")]
        lanelets[int(lanelet.get("id"))] = {
            "sides": sides,
            "right": right is not None and int(right.get("ref")),
            "after": after,
        }
    return tracks, lanelets


def offset(first, second):
    """Steps and shift that carry the second scenario's tracks onto the first's, or None without a shared stretch."""
    votes = {}
    for name in first.keys() & second.keys():
        known = {}
        for step, row in first[name]["rows"].items():
            known.setdefault(row[2:], []).append(step)
        for step, row in second[name]["rows"].items():
            for other in known.get(row[2:], []) if row[3] > 0.5 else []:
                votes[other - step] = votes.get(other - step, 0) + 1
    if not votes or max(votes.values()) < 8:
        return None
    steps = max(votes, key=votes.get)
    shifts = [
        np.subtract(first[name]["rows"][step + steps][:2], row[:2])
        for name in first.keys() & second.keys()
        for step, row in second[name]["rows"].items()
        if step + steps in first[name]["rows"]
    ]
    shift = np.median(shifts, axis=0)
    if np.abs(np.array(shifts) - shift).max() > 0.01:
        raise SystemExit("shared tracks do not agree")
    return steps, shift


def join(scenarios):
    """All tracks of a sequence on one clock in one frame, and {scenario: shift}."""
    names = list(scenarios)
    placed = {names[0]: (0, np.zeros(2))}
    while len(placed) < len(names):
        for base in list(placed):
            for name in names:
                found = None if name in placed else offset(scenarios[base][0], scenarios[name][0])
                if found:
                    placed[name] = (placed[base][0] + found[0], placed[base][1] + found[1])
    origin = min(steps for steps, _ in placed.values())
    tracks = {}
    for name in names:
        steps, shift = placed[name]
        for track_id, track in scenarios[name][0].items():
            joined = tracks.setdefault(track_id, {**track, "rows": {}})
            for step, (x, y, heading, speed) in track["rows"].items():
                joined["rows"][step + steps - origin] = (x + shift[0], y + shift[1], heading, speed)
    return tracks, {name: shift for name, (_, shift) in placed.items()}


def first_lanes(lanelets):
    """Lanes 1 to 5 and the ramp of the first section: the lanelets that no other precedes, from left to right."""
    later = {after for lanelet in lanelets.values() for after in lanelet["after"]}
    heads = [key for key, lanelet in lanelets.items() if key not in later]
    direction = np.subtract(*lanelets[heads[0]]["sides"][0][0][[-1, 0]])
    across = np.array([-direction[1], direction[0]])
    return sorted(heads, key=lambda key: -(lanelets[key]["sides"][0][0][0] @ across))


def lanes_us101(sections, scenarios, shifts):
    """Rows of lanes.csv. Where two pieces of a section overlap the later one begins where the earlier is cut."""
    names = [["L1a", "L2a", "L3a", "L4a", "L5a", "R6a"], ["L1b", "L2b", "L3b", "L4b", "L5b", "A6b"]]
    names.append(["L1c", "L2c", "L3c", "L4c", "L5c", "X6c"])
    tags = ["ramp", "acceleration;deceleration", "ramp"]
    rows = []
    for part, section in enumerate(sections):
        for lane in range(6):
            edges, marks = [], []
            for side in range(2):
                line = np.empty((0, 2))
                for scenario, ids in section:
                    lanelets = scenarios[scenario][1]
                    ids = ids or first_lanes(lanelets)
                    if ids[lane] is None:
                        continue
                    piece, mark = lanelets[ids[lane]]["sides"][side]
                    piece = piece + shifts[scenario]
                    if len(line):
                        along = np.subtract(piece[-1], piece[0])
                        if part == 0:
                            line = line[(line - piece[0]) @ along < -np.hypot(*along)]
                        else:
                            piece = piece[(piece - line[-1]) @ along > np.hypot(*along)]
                    line = np.concatenate([line, piece])
                edges.append("; ".join(f"{x:.3f} {y:.3f}" for x, y in line))
                marks.append({"broad_solid": "solid"}.get(mark, mark or "unknown"))
            apart = lane == 5 and part != 1
            row = {
                "lane_id": names[part][lane],
                "left_xyz_m": edges[0],
                "right_xyz_m": edges[1],
                "left_mark": marks[0],
                "right_mark": marks[1],
                "left_neighbour": names[part][lane - 1] if lane and not apart else "",
                "right_neighbour": names[part][lane + 1] if lane < 4 or (lane == 4 and part == 1) else "",
                "successors": names[part + 1][lane] if part < 2 else "",
                "tags": tags[part] if lane == 5 else "",
            }
            rows.append(row)
    return rows


def lanes_i80():
    rows = []
    for lane in range(1, 7):
        left, right = -(lane - 1) * 12 * FOOT, -lane * 12 * FOOT
        rows.append(
            {
                "lane_id": f"L{lane}",
                "left_xyz_m": f"-20 {left:.3f}; 560 {left:.3f}",
                "right_xyz_m": f"-20 {right:.3f}; 560 {right:.3f}",
                "left_mark": "solid" if lane == 1 else "dashed",
                "right_mark": "unknown" if lane == 6 else "dashed",
                "left_neighbour": f"L{lane - 1}" if lane > 1 else "",
                "right_neighbour": f"L{lane + 1}" if lane < 6 else "",
                "successors": "",
                "tags": "",
            }
        )
    return rows


def read_pairs(path):
    """Tracks of the I-80 table: followers only; a leader is known where it is a follower itself."""
    tracks, leaders = {}, {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            name, step = int(row["vehicle_id"]), round(float(row["frame_id"]))
            length = float(row["v_length"])
            kind = {"1": "motorcycle", "2": "car", "3": "truck"}[row["v_class"]]
            track = {"kind": kind, "length": length, "width": float(row["v_width"]), "rows": {}}
            place = (float(row["local_y"]) - length / 2, -float(row["local_x"]))
            tracks.setdefault(name, track)["rows"][step] = (*place, 0.0, float(row["v_vel"]))
            leaders.setdefault(name, {})[step] = int(row["preceding"])
    return tracks, leaders


def longest_run(steps):
    """Longest stretch of consecutive steps."""
    steps = sorted(steps)
    runs = np.split(np.array(steps), np.flatnonzero(np.diff(steps) != 1) + 1) if steps else [np.array([], int)]
    return max(runs, key=len)


def cut(steps, max_s):
    extra = len(steps) - 1 - round(max_s / STEP_S)
    return steps[extra // 2 : len(steps) - (extra - extra // 2)] if extra > 0 else steps


def lane_numbers(track, edges):
    """Lane of every row: number of inner edges (from the left) that lie left of the place."""
    result = {}
    for step, (x, y, _, _) in track["rows"].items():
        count = 0
        for line in edges:
            i = int(np.argmin(np.hypot(line[:, 0] - x, line[:, 1] - y)))
            a, b = line[max(i - 1, 0)], line[min(i + 1, len(line) - 1)]
            count += (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) < 0
        result[step] = count
    return result


def dense(points):
    """A polyline with a point every metre and a half or so."""
    parts = [np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / 1.5)))[:-1] for a, b in zip(points, points[1:])]
    return np.concatenate([*parts, points[-1:]])


def inner_edges(lanes):
    """The lines between lanes, over all sections."""
    chains = {}
    for row in lanes:
        lane = int(row["lane_id"][1])
        if lane > 1:
            line = [[float(value) for value in point.split()] for point in row["left_xyz_m"].split(";")]
            chains.setdefault(lane, []).extend(line)
    return [dense(np.array(chains[lane])) for lane in sorted(chains)]


def lively(ego, steps, tracks, lanes, axis):
    """The ego changes lane, or another comes into its lane as its next ahead, at most 40 m away; both stay for 1 s."""
    own = lanes[ego]
    inside = set(steps.tolist())
    for name, track in tracks.items():
        for step in track["rows"]:
            stay = [lanes[name].get(step + shift) for shift in (*range(-10, 0), *range(10))]
            if step not in inside or None in stay or len(set(stay[:10])) > 1 or len(set(stay[10:])) > 1:
                continue
            if stay[0] == stay[-1]:
                continue
            if name == ego:
                return True
            ahead = {
                other: np.subtract(row["rows"][step][:2], tracks[ego]["rows"][step][:2]) @ axis
                for other, row in tracks.items()
                if step in row["rows"] and lanes[other][step] == own[step]
            }
            if 0 < ahead.get(name, 0) < 40 and ahead[name] == min(gap for gap in ahead.values() if gap > 0):
                return True
    return False


def chained(ego, steps, others, tracks, lanes, axis):
    """Whether the ego follows or leads one of the others, with nobody between, for half of its time."""
    for other in others:
        count = 0
        for step in steps.tolist():
            rows = {name: track["rows"][step] for name, track in tracks.items() if step in track["rows"]}
            if other not in rows or lanes[other][step] != lanes[ego][step]:
                continue
            along = {n: np.dot(row[:2], axis) for n, row in rows.items() if lanes[n][step] == lanes[ego][step]}
            low, high = sorted((along[ego], along[other]))
            count += high - low < 40 and not any(low < value < high for value in along.values())
        if count > len(steps) / 2:
            return True
    return False


def write_table(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write_drive(folder, source, place, start, ego_name, steps, tracks, lanes):
    folder.mkdir(parents=True, exist_ok=True)
    ego = tracks[ego_name]

    def cells(track, step):
        x, y, heading, speed = track["rows"][step]
        return [f"{x:.3f}", f"{y:.3f}", f"{heading:.5f}", f"{speed:.3f}"]

    write_table(
        folder / "ego.csv",
        ["time_s", "x_m", "y_m", *HEADER],
        ([f"{step * STEP_S:.1f}", *cells(ego, step)] for step in steps.tolist()),
    )
    objects = [
        [f"{step * STEP_S:.1f}", name, track["kind"], *cells(track, step), f"{track['length']:.2f}", track["width"]]
        for step in steps.tolist()
        for name, track in sorted(tracks.items())
        if name != ego_name and step in track["rows"]
    ]
    header = ["time_s", "track_id", "class", "x_m", "y_m", *HEADER, "length_m", "width_m"]
    write_table(folder / "objects.csv", header, objects)
    write_table(folder / "lanes.csv", list(lanes[0]), (row.values() for row in lanes))
    first = f"{steps[0] * STEP_S:.1f}"
    context = [[first, "road_type", "motorway"], [first, "lighting", "day"]]
    write_table(folder / "context.csv", ["time_s", "kind", "value"], context)
    (folder / "drive.yaml").write_text(
        f"""drive_id: {folder.name}
source: {source}
place: {place}
start_time: {start}
ego:
  reference_to_centre_m: 0
  length_m: {ego["length"]:.2f}
  width_m: {ego["width"]:.2f}
""",
        encoding="utf-8",
    )


def draw(candidates, count, wanted, is_lively, is_chained):
    """Ids in the order of their hashes; see the module's text."""
    order = sorted(candidates, key=lambda drive: hashlib.sha256(drive.encode()).hexdigest())
    drawn = []
    for drive in order:
        if len(drawn) < count and not is_chained(drive, drawn):
            drawn.append(drive)
    for drive in order[order.index(drawn[-1]) + 1 :]:
        calm = [other for other in drawn if not is_lively(other)]
        if len(drawn) - len(calm) >= wanted or not calm:
            break
        rest = [other for other in drawn if other != calm[-1]]
        if is_lively(drive) and not is_chained(drive, rest):
            drawn = [*rest, drive]
    return drawn


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("place", choices=["us101", "i80"])
    parser.add_argument("--scenarios", type=Path, help="folder with USA_US101-*.xml")
    parser.add_argument("--tracks", type=Path, help="table of pairs as CSV")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--egos", type=int, default=23)
    parser.add_argument("--lively", type=int, default=0, help="so many with a lane change or a cut-in")
    parser.add_argument("--min-seconds", type=float, default=12)
    parser.add_argument("--max-seconds", type=float, default=40)
    args = parser.parse_args()

    records, candidates = {}, {}
    if args.place == "us101":
        for key, sequence in SEQUENCES.items():
            files = {name: args.scenarios / f"USA_US101-{name}_T-1.xml" for name in sequence["scenarios"]}
            scenarios = {name: read_scenario(path) for name, path in files.items()}
            tracks, shifts = join(scenarios)
            lanes = lanes_us101(sequence["sections"], scenarios, shifts)
            records[key] = ("ngsim-us101", "Los Angeles", sequence["start"], tracks, lanes)
            for name, track in tracks.items():
                candidates[f"ngsim_us101{key}_{name}"] = (key, name, longest_run(track["rows"]))
    else:
        tracks, leaders = read_pairs(args.tracks)
        records["i80"] = ("ngsim-i80", "Emeryville", "2005-04-13T23:00:00Z", tracks, lanes_i80())
        for name, track in tracks.items():
            known = [step for step in track["rows"] if step in tracks.get(leaders[name][step], {"rows": ()})["rows"]]
            candidates[f"ngsim_i80_{name}"] = ("i80", name, longest_run(known))
    candidates = {
        drive: (key, name, cut(steps, args.max_seconds))
        for drive, (key, name, steps) in candidates.items()
        if len(steps) > args.min_seconds / STEP_S
    }
    numbers, axes = {}, {}
    for key, (_, _, _, tracks, lanes) in records.items():
        edges = inner_edges(lanes)
        numbers[key] = {name: lane_numbers(track, edges) for name, track in tracks.items()}
        axes[key] = (edges[0][-1] - edges[0][0]) / np.hypot(*(edges[0][-1] - edges[0][0]))
    memory = {}

    def is_lively(drive):
        key, name, steps = candidates[drive]
        if drive not in memory:
            memory[drive] = lively(name, steps, records[key][3], numbers[key], axes[key])
        return memory[drive]

    def is_chained(drive, drawn):
        key, name, steps = candidates[drive]
        others = [candidates[other][1] for other in drawn if candidates[other][0] == key]
        return chained(name, steps, others, records[key][3], numbers[key], axes[key])

    drawn = draw(candidates, args.egos, args.lively, is_lively, is_chained)
    print(len(candidates), "candidates")
    for drive in sorted(drawn):
        key, name, steps = candidates[drive]
        source, place, start, tracks, lanes = records[key]
        write_drive(args.out / drive, source, place, start, name, steps, tracks, lanes)
        print(drive, f"{(len(steps) - 1) * STEP_S:.1f} s", "lively" if is_lively(drive) else "")


if __name__ == "__main__":
    main()
