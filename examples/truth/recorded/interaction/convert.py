"""Drives in whyroad's table layout from recordings of the INTERACTION dataset.

INTERACTION (Zhan et al. 2019, https://interaction-dataset.com, for research only) has recordings of junctions,
roundabouts and merges by drones: boxes at 10 Hz in `vehicle_tracks_NNN.csv`, pedestrians and bicycles in
`pedestrian_tracks_NNN.csv`, and a Lanelet2 map in degrees around 0, 0. A recording has no recording vehicle: each
chosen vehicle becomes the ego of one drive, and all other tracks are its objects. The map is not converted; give it
to the ingest:

    convert.py --scene of --tracks vehicle_tracks_000.csv pedestrian_tracks_000.csv --out drives
    whyroad ingest table drives --map DR_DEU_Roundabout_OF.osm --map-origin 0,0 --lake lake

What is set here and not in the data: time 0 of a recording is 1970-01-01T00:00:00Z, as no date is published. The
data's `car` is any motor vehicle: longer than 7 m becomes large_vehicle. Its `pedestrian/bicycle` becomes bicyclist
when the median speed is above 3 m/s, otherwise pedestrian. Heights, colors of lights and turn signals are not there.
"""

import argparse
import csv
import hashlib
from pathlib import Path

import numpy as np

LARGE_M = 7.0
BICYCLE_MPS = 3.0


def read_tracks(paths, shift):
    """Columns by track: {id: {"class": str, "t": ms as integers, "x": ...}}; missing columns are NaN."""
    rows = {}
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                rows.setdefault(row["track_id"], []).append(row)
    tracks = {}
    for name, track_rows in rows.items():
        track_rows.sort(key=lambda row: int(row["timestamp_ms"]))

        def column(key, rows=track_rows):
            return np.array([float(row.get(key) or "nan") for row in rows])

        track = {key: column(key) for key in ("x", "y", "vx", "vy", "psi_rad", "length", "width")}
        track["t"] = np.array([int(row["timestamp_ms"]) for row in track_rows])
        track["x"] += shift[0]
        track["y"] += shift[1]
        track["class"] = kind(track_rows[0]["agent_type"], track)
        tracks[name] = track
    return tracks


def kind(agent_type, track):
    if agent_type == "car":
        return "large_vehicle" if np.nanmedian(track["length"]) > LARGE_M else "car"
    if agent_type == "pedestrian/bicycle":
        return "bicyclist" if np.median(np.hypot(track["vx"], track["vy"])) > BICYCLE_MPS else "pedestrian"
    return "unknown"


def eligible(track, min_s, min_m):
    path = np.hypot(np.diff(track["x"]), np.diff(track["y"])).sum()
    seen = (track["t"][-1] - track["t"][0]) / 1000
    return track["class"] in ("car", "large_vehicle") and seen >= min_s and path >= min_m


def span(track, max_s):
    """First and last time in ms, cut to max_s around the middle, on the recording's 100 ms."""
    first, last = int(track["t"][0]), int(track["t"][-1])
    if last - first > max_s * 1000:
        middle = (first + last) // 200 * 100
        first, last = middle - int(max_s * 500), middle + int(max_s * 500)
    return first, last


def cell(value, digits):
    return "" if np.isnan(value) else f"{value:.{digits}f}"


def write_table(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def states(track, first, last):
    """Time, place, heading and velocity of a track in [first, last]."""
    for i in np.flatnonzero((track["t"] >= first) & (track["t"] <= last)):
        places = [cell(track[key][i], 3) for key in ("x", "y")]
        motion = [cell(track["psi_rad"][i], 4), cell(track["vx"][i], 3), cell(track["vy"][i], 3)]
        yield i, f"{track['t'][i] / 1000:.1f}", places, motion


def write_drive(folder, scene, ego_name, tracks, max_s):
    ego = tracks[ego_name]
    first, last = span(ego, max_s)
    folder.mkdir(parents=True, exist_ok=True)
    motion_header = ["heading_rad", "vx_mps", "vy_mps"]
    write_table(
        folder / "ego.csv",
        ["time_s", "x_m", "y_m", *motion_header],
        ([time, *place, *motion] for _, time, place, motion in states(ego, first, last)),
    )
    objects = []
    for name, track in tracks.items():
        if name == ego_name:
            continue
        for i, time, place, motion in states(track, first, last):
            size = [cell(track["length"][i], 2), cell(track["width"][i], 2)]
            objects.append([time, name, track["class"], *place, *motion, *size])
    objects.sort(key=lambda row: (float(row[0]), row[1]))
    header = ["time_s", "track_id", "class", "x_m", "y_m", *motion_header, "length_m", "width_m"]
    write_table(folder / "objects.csv", header, objects)
    (folder / "drive.yaml").write_text(
        f"""drive_id: {folder.name}
source: interaction-{scene}
start_time: 1970-01-01T00:00:00Z
ego:
  reference_to_centre_m: 0
  length_m: {np.nanmedian(ego["length"]):.2f}
  width_m: {np.nanmedian(ego["width"]):.2f}
""",
        encoding="utf-8",
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", required=True, help="short name, part of the drive ids: interaction_SCENE_TRACK")
    parser.add_argument("--tracks", nargs="+", required=True, help="vehicle and pedestrian tracks of one recording")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--egos", type=int, default=10, help="number of drives, drawn by SHA-256 of their ids")
    parser.add_argument("--exclude", nargs="*", default=[], help="track ids never drawn, such as trailers")
    parser.add_argument("--shift", type=float, nargs=2, default=[0, 0], metavar=("X", "Y"), help="added to x and y, m")
    parser.add_argument("--min-seconds", type=float, default=6)
    parser.add_argument("--min-metres", type=float, default=15, help="length of the ego's path")
    parser.add_argument("--max-seconds", type=float, default=30, help="longer drives are cut around their middle")
    args = parser.parse_args()

    tracks = read_tracks(args.tracks, args.shift)
    ids = {
        f"interaction_{args.scene}_{name}": name
        for name, track in tracks.items()
        if name not in args.exclude and eligible(track, args.min_seconds, args.min_metres)
    }
    drawn = sorted(ids, key=lambda drive: hashlib.sha256(drive.encode()).hexdigest())[: args.egos]
    for drive in sorted(drawn):
        write_drive(args.out / drive, args.scene, ids[drive], tracks, args.max_seconds)
        print(drive)


if __name__ == "__main__":
    main()
