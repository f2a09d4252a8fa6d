#!/usr/bin/env python3
"""RefAV's definitions worked out with NumPy alone on AV2 sensor logs, against our `refav_` signals, row by row.

    python3 compare.py LOG_FOLDER...            prints the agreement (runs the example `dump` of whyroad-signals)
    python3 compare.py --counts LOG_FOLDER...   prints how often each answer is given: counts.csv, which a test holds us to

Written from refAV/atomic_functions.py (MIT), with its median filter over seven positions and velocities; nothing of it is imported, and
nothing of ours. Where it differs from that file on purpose: the ego's box is centered in the middle of the car (there its rear end
has the wrong sign), exactly 180 deg is opposite, and lanes near a position are found by distance to the polygon (there by mitred corners).
Needs numpy and pyarrow.
"""

import csv
import io
import json
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
import pyarrow.feather as feather

EGO = "ego"
# Half way along the car, ahead of the rear axle, where AV2's ego frame has its origin (m); length and width.
EGO_AHEAD, EGO_LENGTH, EGO_WIDTH = 1.339, 4.877, 2.0
NO_WILL = {"BICYCLE", "CONSTRUCTION_CONE", "CONSTRUCTION_BARREL", "BOLLARD", "SIGN", "STOP_SIGN", "TRAFFIC_LIGHT_TRAILER",
           "MESSAGE_BOARD_TRAILER", "MOBILE_PEDESTRIAN_SIGN", "MOBILE_PEDESTRIAN_CROSSING_SIGN"}


def matrices(q):
    w, x, y, z = q.T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
                     2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1).reshape(-1, 3, 3)


def median7(v):
    n = min(7, len(v))
    # scipy.ndimage.median_filter with mode nearest: an even window reaches one farther back.
    before, after = n // 2, n - 1 - n // 2
    padded = np.concatenate([np.repeat(v[:1], before, 0), v, np.repeat(v[-1:], after, 0)])
    return np.sort(np.stack([padded[i:i + len(v)] for i in range(n)]), 0)[n // 2]


def derivative(v, t):
    last = len(v) - 1
    i = np.arange(len(v))
    a, b = np.maximum(i - 1, 0), np.minimum(i + 1, last)
    return (v[b] - v[a]) / np.maximum(t[b] - t[a], 1e-9)[:, None] if last else np.zeros_like(v)


def wrap(a):
    return (a + np.pi) % (2 * np.pi) - np.pi


class Track:
    def __init__(self, frames, t, position, yaw, length, width, category):
        self.frames, self.t, self.yaw, self.length, self.width, self.category = frames, t, yaw, length, width, category
        self.raw = position
        self.position = median7(position)
        self.velocity = median7(derivative(position, t))
        d = np.array([wrap(yaw[min(i + 1, len(yaw) - 1)] - yaw[max(i - 1, 0)]) for i in range(len(yaw))])
        span = np.array([t[min(i + 1, len(t) - 1)] - t[max(i - 1, 0)] for i in range(len(t))])
        self.rate = np.degrees(d / np.maximum(span, 1e-9)) if len(t) > 1 else np.zeros(len(t))
        self.at = {f: i for i, f in enumerate(frames)}


def load(folder):
    file = next(f for f in ("annotations_with_ego.feather", "annotations.feather") if (folder / f).exists())
    rows = feather.read_table(folder / file).to_pandas()
    poses = feather.read_table(folder / "city_SE3_egovehicle.feather").to_pandas()
    stamps = np.sort(rows.timestamp_ns.unique())
    poses = poses.sort_values("timestamp_ns")
    nearest = np.abs(poses.timestamp_ns.to_numpy()[None, :] - stamps[:, None]).argmin(1)
    pose = poses.iloc[nearest]
    rotation = matrices(pose[["qw", "qx", "qy", "qz"]].to_numpy())
    shift = pose[["tx_m", "ty_m", "tz_m"]].to_numpy()
    frame_of = {s: i for i, s in enumerate(stamps)}
    seconds = (stamps - stamps[0]) / 1e9
    tracks = {}
    for uuid, part in rows[rows.category != "EGO_VEHICLE"].groupby("track_uuid"):
        part = part.sort_values("timestamp_ns")
        frames = np.array([frame_of[s] for s in part.timestamp_ns])
        local = part[["tx_m", "ty_m", "tz_m"]].to_numpy()
        position = np.einsum("nij,nj->ni", rotation[frames], local) + shift[frames]
        turned = rotation[frames] @ matrices(part[["qw", "qx", "qy", "qz"]].to_numpy())
        first = part.iloc[0]
        track = Track(frames, seconds[frames], position, np.arctan2(turned[:, 1, 0], turned[:, 0, 0]), first.length_m, first.width_m,
                      first.category)
        track.sizes = part[["length_m", "width_m"]].to_numpy()
        tracks[uuid] = track
    frames = np.arange(len(stamps))
    centre = shift + rotation @ np.array([EGO_AHEAD, 0.0, 0.0])
    ego = Track(frames, seconds, centre, np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]), EGO_LENGTH, EGO_WIDTH, "EGO_VEHICLE")
    lanes = json.loads(next((folder / "map").glob("log_map_archive_*.json")).read_text())["lane_segments"].values()
    for lane in lanes:
        point = lambda p: (p["x"], p["y"])
        lane["ring"] = np.array([point(p) for p in lane["left_lane_boundary"]] + [point(p) for p in lane["right_lane_boundary"]][::-1])
    return ego, tracks, list(lanes)


def inside(ring, p):
    a, b = ring, np.roll(ring, -1, 0)
    over = (a[:, 1] > p[1]) != (b[:, 1] > p[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (p[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return bool((over & (p[0] < x)).sum() % 2)


def from_segments(a, b, p):
    ab = b - a
    share = np.clip(((p - a) * ab).sum(1) / np.maximum((ab * ab).sum(1), 1e-12), 0, 1)
    return np.linalg.norm(p - a - ab * share[:, None], axis=1).min()


def corners(centre, yaw, length, width):
    along, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    return np.array([centre + along * x * length / 2 + left * y * width / 2 for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))])


def box_distance(a, b):
    for axis in np.concatenate([a - np.roll(a, -1, 0), b - np.roll(b, -1, 0)]):
        p, q = a @ axis, b @ axis
        if p.max() < q.min() or q.max() < p.min():
            break
    else:
        return 0.0
    return min(min(from_segments(b, np.roll(b, -1, 0), p) for p in a), min(from_segments(a, np.roll(a, -1, 0), p) for p in b))


def turning(track):
    rate, n = track.rate, len(track.rate)
    found = ["none"] * n
    start = end = 0
    while start < n - 1:
        if rate[start] * rate[end] > 0 and end < n - 1:
            end += 1
            continue
        run = rate[start:end + 1]
        total = run.sum() * (track.t[1] - track.t[0])
        for side, sign in (("left", 1), ("right", -1)):
            cut = (start == 0 and sign * rate[start] > 5) or (end == n - 1 and sign * rate[end] > 5)
            if sign * total > 45 or (cut and sign * run.mean() > 5 and sign * total > 15):
                found[start:end + 1] = [side] * (end + 1 - start)
        start, end = end, end + 1
    return found


def lane_of(track, lanes):
    """RefAV's assignment: of the lanes that hold a position, the one that holds most of the track (its tie break by yaw left out)."""
    buckets = defaultdict(list)
    for i, p in enumerate(track.position[:, :2]):
        for k, lane in enumerate(lanes):
            low, high = lane["ring"].min(0), lane["ring"].max(0)
            if (p >= low).all() and (p <= high).all() and inside(lane["ring"], p):
                buckets[k].append(i)
    found = [None] * len(track.frames)
    while buckets:
        best = max(buckets, key=lambda k: len(buckets[k]))
        taken = set(buckets.pop(best))
        for i in taken:
            found[i] = lanes[best]
        buckets = {k: left for k, rows in buckets.items() if (left := [i for i in rows if i not in taken])}
    return found


def answers(ego, tracks, lanes):
    """Yields (who, frame, question, value)."""
    junctions = [lane["ring"] for lane in lanes if lane["is_intersection"]]
    ego_lanes = lane_of(ego, lanes)
    for who, track in [(EGO, ego), *tracks.items()]:
        extent = track.position.max(0) - track.position.min(0)
        still = "true" if np.linalg.norm(extent) < 3 else "false"
        for i, (frame, turn) in enumerate(zip(track.frames, turning(track))):
            p = track.position[i, :2]
            yield who, frame, "stationary", still
            yield who, frame, "turning", turn
            near = any(inside(r, p) or from_segments(r, np.roll(r, -1, 0), p) <= 5 for r in junctions
                       if (p >= r.min(0) - 5).all() and (p <= r.max(0) + 5).all())
            yield who, frame, "near_intersection", "true" if near else "false"
    half, side = ego.length / 2, ego.width / 2
    for who, track in tracks.items():
        own = np.array([ego.at[f] for f in track.frames])
        c, s = np.cos(ego.yaw[own]), np.sin(ego.yaw[own])
        turn = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], 1)
        at = np.einsum("nij,nj->ni", turn, track.position[:, :2] - ego.raw[own, :2])
        v = np.einsum("nij,nj->ni", turn, track.velocity[:, :2])
        ve = np.einsum("nij,nj->ni", turn, ego.velocity[own, :2])
        on = lane_of(track, lanes)
        for i, frame in enumerate(track.frames):
            x, y = at[i]
            own_box = corners(ego.raw[own[i], :2], ego.yaw[own[i]], ego.length, ego.width)
            box = corners(track.raw[i, :2], track.yaw[i], *track.sizes[i])
            where = "none"
            if box_distance(own_box, box) <= 50:
                where = "front" if x > half else "back" if x < -half else "left" if y > side else "right" if y < -side else "none"
            yield who, frame, "relative_direction", where
            direction = lambda u, yaw: u / np.linalg.norm(u) if np.linalg.norm(u) > 0.5 else np.array([np.cos(yaw), np.sin(yaw)])
            alike = direction(v[i], track.yaw[i] - ego.yaw[own[i]]) @ direction(ve[i], 0.0) > 0.5
            a, b = ego_lanes[own[i]], on[i]
            follows = False
            if a and b and alike and half < x < 25 + half:
                same = a["id"] == b["id"] or b["id"] in a["successors"]
                beside = b["id"] in (a["left_neighbor_id"], a["right_neighbor_id"])
                reaches = any(-side <= y + k * track.width / 2 <= side for k in (1, -1))
                follows = (same and -5 < y < 5) or (beside and reaches)
            yield who, frame, "following", "true" if follows else "false"
            slow, slow_ego = np.linalg.norm(track.velocity[i]), np.linalg.norm(ego.velocity[own[i]])
            d, e = track.velocity[i, :2], ego.velocity[own[i], :2]
            unit = lambda yaw: np.array([np.cos(yaw), np.sin(yaw)])
            heading = None
            if slow < 1 and track.category not in NO_WILL and slow_ego > 1:
                d = unit(track.yaw[i])
            elif slow_ego < 1 and slow > 0.5:
                e = unit(ego.yaw[own[i]])
            elif slow < 1 or slow_ego < 1:
                heading = "none"
            if heading is None:
                angle = np.degrees(abs(wrap(np.arctan2(d[1], d[0]) - np.arctan2(e[1], e[0]))))
                heading = "same" if angle <= 45 else "opposite" if angle >= 135 else "perpendicular"
            yield who, frame, "heading", heading
        crossed = set()
        for i in range(1, len(at)):
            y0, y1 = at[i - 1, 1], at[i, 1]
            over = any(y0 < line < y1 or y1 < line < y0 for line in (-side, side))
            if over and abs(v[i, 1]) > 0.2 and half <= at[i, 0] <= half + 10:
                sign = np.sign(y1 - y0)
                goes_on = lambda j: sign * at[j, 1] < 5 and sign * v[j, 1] > 0.2
                j = i - 1
                while j >= 0 and goes_on(j):
                    crossed.add(j)
                    j -= 1
                j = i
                while j < len(at) and goes_on(j):
                    crossed.add(j)
                    j += 1
        for i, frame in enumerate(track.frames):
            yield who, frame, "crossed_by", "true" if i in crossed else "false"


QUESTIONS = ["stationary", "turning", "near_intersection"]
OF_TARGETS = ["relative_direction", "following", "heading", "crossed_by"]


def ours(folder):
    """{(who, frame, question): value} from the example `dump`; unknown is left out."""
    def dump(target, names):
        command = ["cargo", "run", "-q", "-p", "whyroad-signals", "--example", "dump", "--", str(folder), target, *names]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return csv.DictReader(io.StringIO(text))
    word = {"1": "true", "0": "false"}
    found = {}
    for row in dump("all", [f"target.refav_{q}" for q in QUESTIONS + OF_TARGETS]):
        for q in QUESTIONS + OF_TARGETS:
            value = row[f"target.refav_{q}"]
            if value:
                found[row["target"], int(row["frame"]), q] = word.get(value, value)
    for frame, row in enumerate(dump("-", [f"ego.refav_{q}" for q in QUESTIONS])):
        for q in QUESTIONS:
            if row[f"ego.refav_{q}"]:
                found[EGO, frame, q] = word.get(row[f"ego.refav_{q}"], row[f"ego.refav_{q}"])
    return found


def main():
    counts = "--counts" in sys.argv
    both, theirs, own = Counter(), Counter(), Counter()
    if counts:
        print("log,who,question,value,rows")
    for folder in [Path(a) for a in sys.argv[1:] if a != "--counts"]:
        told = list(answers(*load(folder)))
        if counts:
            tally = Counter(("ego" if who == EGO else "target", q, value) for who, _, q, value in told if value not in ("false", "none"))
            for (who, q, value), n in sorted(tally.items()):
                print(f"{folder.name[:8]},{who},{q},{value},{n}")
            continue
        mine = ours(folder)
        for who, frame, q, value in told:
            answer = mine.get((who, int(frame), q))
            for v in {value, answer} - {"false", "none", None}:
                (both if value == answer else theirs if v == value else own)[q, v] += 1
    for key in sorted(both | theirs | own):
        n = both[key] + theirs[key] + own[key]
        print(f"{key[0]} {key[1]}: both {both[key]}, theirs only {theirs[key]}, ours only {own[key]}: {100 * both[key] / n:.2f} %")


if __name__ == "__main__":
    main()
