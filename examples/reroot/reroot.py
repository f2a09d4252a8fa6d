#!/usr/bin/env python3
"""Makes other drives of a recording: another tracked vehicle becomes the ego, and the recording car an object.

Same road, same traffic, same noise; another way driven. Reads Argoverse 2 sensor logs, Argoverse 2 motion scenarios and
ScenarioNet pickles, and writes the same formats, one drive per vehicle:

    python3 reroot.py OUT LOG... [--least-seconds 8] [--least-metres 15] [--window 9 --every 6]

A new ego is a vehicle that was seen without a gap for `--least-seconds` and got `--least-metres` from where it began.
`--window` and `--every` also cut each drive into windows of that many seconds, started that far apart.
What the recording car did not see, the new drive does not contain: it is emptier around its ego than a drive of its own.

Needs numpy, pandas and pyarrow. The output keeps the license of its source.
"""

import argparse
import pickle
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as parquet

VEHICLES = {
    "REGULAR_VEHICLE", "LARGE_VEHICLE", "BUS", "BOX_TRUCK", "TRUCK", "TRUCK_CAB", "SCHOOL_BUS", "ARTICULATED_BUS",
}
# Rear axle to the middle of Argoverse 2's car, m: forward, left, up; and its size, length, width, height.
AXLE_TO_MIDDLE = np.array([1.339, 0.0, 0.438])
CAR = (4.877, 2.0, 1.473)
# Steps longer than this end a run, s.
GAP_S = 0.3
RECORDER = "recording-vehicle"


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("out", type=Path)
    arguments.add_argument("logs", type=Path, nargs="+")
    arguments.add_argument("--least-seconds", type=float, default=8.0)
    arguments.add_argument("--least-metres", type=float, default=15.0)
    arguments.add_argument("--window", type=float)
    arguments.add_argument("--every", type=float, default=6.0)
    options = arguments.parse_args()
    for log in options.logs:
        if log.suffix == ".pkl":
            made = scenario(log, options)
        elif list(log.glob("scenario_*.parquet")):
            made = motion_scenario(log, options)
        else:
            made = sensor_log(log, options)
        print(f"{log.name}: {made} drives")


def spans(seconds, positions, options):
    """First and last index (inclusive) of each drive of one vehicle: its longest run, whole or cut into windows."""
    breaks = np.flatnonzero(np.diff(seconds) > GAP_S) + 1
    runs = np.split(np.arange(len(seconds)), breaks)
    run = max(runs, key=len, default=np.array([], dtype=int))
    if len(run) < 2 or seconds[run[-1]] - seconds[run[0]] < options.least_seconds:
        return
    if not options.window:
        windows = [run]
    else:
        starts = np.arange(seconds[run[0]], seconds[run[-1]], options.every)
        windows = [run[(seconds[run] >= s) & (seconds[run] <= s + options.window)] for s in starts]
        windows = [w for w in windows if len(w) and seconds[w[-1]] - seconds[w[0]] >= options.window - 0.2]
    for window in windows:
        if np.linalg.norm(positions[window] - positions[window[0]], axis=1).max() >= options.least_metres:
            yield window[0], window[-1]


def short(name):
    """An id as part of a folder's name."""
    return re.sub(r"[^A-Za-z0-9]", "", name)[:8]


def rotation(q):
    """Rotation matrices of quaternions (w, x, y, z), n x 3 x 3."""
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack([
        np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
        np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
        np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
    ], 1)


def product(a, b):
    """Products of quaternions, row by row."""
    w, x, y, z = a.T
    p, q, r, s = b.T
    return np.stack([w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r,
                     w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p], -1)


def sensor_log(log, options):
    """An Argoverse 2 sensor log: `annotations.feather`, `city_SE3_egovehicle.feather`, `map/`."""
    with_ego = log / "annotations_with_ego.feather"
    rows = feather.read_table(with_ego if with_ego.exists() else log / "annotations.feather").to_pandas()
    rows = rows[rows.category != "EGO_VEHICLE"].reset_index(drop=True)
    poses = feather.read_table(log / "city_SE3_egovehicle.feather").to_pandas().sort_values("timestamp_ns")
    quaternion, place = ["qw", "qx", "qy", "qz"], ["tx_m", "ty_m", "tz_m"]
    # The pose nearest to each annotation: the file has about 170 a second.
    times = poses.timestamp_ns.to_numpy()
    right = np.searchsorted(times, rows.timestamp_ns).clip(1, len(times) - 1)
    stamps = rows.timestamp_ns.to_numpy()
    nearest = np.where(stamps - times[right - 1] < times[right] - stamps, right - 1, right)
    ego_q, ego_t = poses[quaternion].to_numpy()[nearest], poses[place].to_numpy()[nearest]
    rows[quaternion] = product(ego_q, rows[quaternion].to_numpy())
    rows[place] = np.einsum("nij,nj->ni", rotation(ego_q), rows[place].to_numpy()) + ego_t
    # The recording car as one of the objects, in the city frame too.
    frames, first = np.unique(stamps, return_index=True)
    recorder = rows.iloc[first].copy()
    recorder["track_uuid"], recorder["category"] = RECORDER, "REGULAR_VEHICLE"
    recorder[["length_m", "width_m", "height_m"]] = CAR
    recorder[quaternion] = ego_q[first]
    recorder[place] = ego_t[first] + rotation(ego_q[first]) @ AXLE_TO_MIDDLE
    if "num_interior_pts" in rows:
        recorder["num_interior_pts"] = rows.num_interior_pts.median()
    everyone = pd.concat([rows, recorder], ignore_index=True)

    made = 0
    for track, own in rows[rows.category.isin(VEHICLES)].groupby("track_uuid"):
        own = own.sort_values("timestamp_ns")
        seconds = (own.timestamp_ns - frames[0]).to_numpy() * 1e-9
        for a, b in spans(seconds, own[["tx_m", "ty_m"]].to_numpy(), options):
            part = own.iloc[a:b + 1]
            own_q = part[quaternion].to_numpy()
            origin = part[place].to_numpy() - rotation(own_q) @ AXLE_TO_MIDDLE
            pose = part[["timestamp_ns"]].assign(**dict(zip(quaternion, own_q.T)), **dict(zip(place, origin.T)))
            inside = everyone[everyone.timestamp_ns.isin(part.timestamp_ns)].copy()
            at = np.searchsorted(part.timestamp_ns.to_numpy(), inside.timestamp_ns)
            back = own_q[at] * [1, -1, -1, -1]
            inside[quaternion] = product(back, inside[quaternion].to_numpy())
            inside[place] = np.einsum("nij,nj->ni", rotation(back), inside[place].to_numpy() - origin[at])
            inside.loc[inside.track_uuid == track, "category"] = "EGO_VEHICLE"
            folder = options.out / f"{short(log.name)}-{short(track)}-{round(seconds[a] * 10):03d}"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            write = lambda table, name: feather.write_feather(pa.Table.from_pandas(table, preserve_index=False),
                                                              folder / name)
            write(inside.sort_values(["timestamp_ns", "track_uuid"]), "annotations_with_ego.feather")
            write(pose, "city_SE3_egovehicle.feather")
            if (log / "map").is_dir():
                shutil.copytree(log / "map", folder / "map")
            made += 1
    return made


def motion_scenario(log, options):
    """An Argoverse 2 motion scenario: `scenario_*.parquet` and its map."""
    rows = parquet.read_table(next(log.glob("scenario_*.parquet"))).to_pandas()
    made = 0
    for track, own in rows[rows.object_type.isin(["vehicle", "bus"]) & (rows.track_id != "AV")].groupby("track_id"):
        own = own.sort_values("timestep")
        for a, b in spans(own.timestep.to_numpy() * 0.1, own[["position_x", "position_y"]].to_numpy(), options):
            steps = own.timestep.iloc[a:b + 1]
            part = rows[rows.timestep.isin(steps)].copy()
            part["track_id"] = part.track_id.replace({track: "AV", "AV": RECORDER})
            part["timestep"] -= steps.iloc[0]
            name = f"{short(log.name)}-{short(track)}-{steps.iloc[0]:03d}"
            part["scenario_id"] = name
            folder = options.out / name
            folder.mkdir(parents=True, exist_ok=True)
            parquet.write_table(pa.Table.from_pandas(part, preserve_index=False), folder / f"scenario_{name}.parquet")
            for map_file in log.glob("log_map_archive_*.json"):
                shutil.copy(map_file, folder / f"log_map_archive_{name}.json")
            made += 1
    return made


def scenario(log, options):
    """A ScenarioNet pickle."""
    with log.open("rb") as file:
        whole = pickle.load(file)  # a file of a data set that the user has; never one from a stranger
    seconds = np.asarray(whole["metadata"]["ts"], dtype=float)
    ego = whole["metadata"]["sdc_id"]
    made = 0
    for track, content in whole["tracks"].items():
        if content["type"] != "VEHICLE" or track == ego:
            continue
        seen = np.flatnonzero(content["state"]["valid"])
        positions = np.asarray(content["state"]["position"])[:, :2]
        for a, b in spans(seconds[seen], positions[seen], options):
            first, last = seen[a], seen[b]
            name = f"sd_{log.stem[-10:]}-{short(track)}-{round(seconds[first] * 10):03d}"
            part = cut(whole, first, last + 1)
            part["id"] = name
            part["metadata"] |= {"sdc_id": track, "ts": seconds[first:last + 1] - seconds[first], "scenario_id": name}
            options.out.mkdir(parents=True, exist_ok=True)
            with (options.out / f"{name}.pkl").open("wb") as file:
                pickle.dump(part, file)
            made += 1
    return made


def cut(whole, first, end):
    """The scenario's frames from `first` until before `end`; everything that has one value per frame is cut."""
    length = whole["length"]

    def per_frame(value):
        if isinstance(value, dict):
            return {k: per_frame(v) for k, v in value.items()}
        if isinstance(value, (np.ndarray, list)) and len(value) == length:
            return value[first:end]
        return value

    part = {k: v for k, v in whole.items() if k not in ("tracks", "dynamic_map_states", "metadata")}
    part["length"] = end - first
    part["metadata"] = dict(whole["metadata"])
    for group in ("tracks", "dynamic_map_states"):
        part[group] = {k: {**v, "state": per_frame(v["state"])} for k, v in whole[group].items()}
    return part


if __name__ == "__main__":
    main()
