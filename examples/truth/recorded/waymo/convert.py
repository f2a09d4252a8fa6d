#!/usr/bin/env python3
"""Makes ScenarioNet pickles of Waymo scenes in the JSON form of GPUDrive, one drive per ego.

    python3 convert.py OUT JSON|PICKLE... [--egos FILE]

GPUDrive (github.com/Emerge-Lab/gpudrive, github.com/sounakban/gpudrive-CoDec) has had such files in `data/` in the
course of its history; they are not part of this project and keep the license of the Waymo Open Dataset. FILE names one
drive per line, as in `drives` of the truth files here: the file's name without `tfrecord-` and `-of-`, and the ego's id.
Without it the recording car becomes the ego, where the file names it. A PICKLE of ScenarioNet that holds 20 s
(github.com/metadriverse/trafficgen, NUMBER_SCENE.pkl: drives 20s_SCENE_EGO) is cut to those egos; other than JSON, it
has what the map states.

What a file does not have stays out: kinds of lanes and lines, lights, heights, which lanes lead into which or are
beside each other. Headings come in degrees or radians; the velocities decide which. Needs numpy.
"""

import argparse
import json
import math
import pickle
from pathlib import Path

import numpy as np

STEPS, STEP_S = 91, 0.1
LANES = {1: "LANE_FREEWAY", 2: "LANE_SURFACE_STREET", 3: "LANE_BIKE_LANE"}
LINES = {
    6: "BROKEN_SINGLE_WHITE", 7: "SOLID_SINGLE_WHITE", 8: "SOLID_DOUBLE_WHITE", 9: "BROKEN_SINGLE_YELLOW",
    10: "BROKEN_DOUBLE_YELLOW", 11: "SOLID_SINGLE_YELLOW", 12: "SOLID_DOUBLE_YELLOW", 13: "PASSING_DOUBLE_YELLOW",
}
KINDS = {"vehicle": "VEHICLE", "pedestrian": "PEDESTRIAN", "cyclist": "CYCLIST"}
# A vehicle that is faster than this goes where it heads, m/s.
MOVING_MPS = 3.0


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("out", type=Path)
    arguments.add_argument("scenes", type=Path, nargs="+")
    arguments.add_argument("--egos", type=Path)
    options = arguments.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    drives = options.egos.read_text().split() if options.egos else []
    for path in options.scenes:
        if path.suffix == ".pkl":
            cut_longer(options.out, path, drives)
            continue
        scene = json.loads(path.read_text())
        name = path.name.split(".")[0].removeprefix("tfrecord-").replace("-of-", "o")
        egos = [drive.rsplit("_", 1)[1] for drive in drives if drive.rsplit("_", 1)[0] == name]
        if not options.egos and "metadata" in scene:
            k = scene["metadata"]["sdc_track_index"]
            egos = [str(scene["objects"][k].get("id", k))]
        if egos and all(len(o["position"]) >= STEPS for o in scene["objects"]):
            parts = tracks(scene["objects"]), lights(scene.get("tl_states") or {}), features(scene["roads"])
            for ego in egos:
                write(options.out, f"{name}_{ego}", ego, *parts)


def cut_longer(out, path, drives):
    """Writes the drives of these egos in a longer scene that is a ScenarioNet pickle already."""
    scene = pickle.loads(path.read_bytes())
    name = "20s_" + path.stem.rsplit("_", 1)[-1]
    lights = {
        str(lane): light | {"lane": str(light["lane"])} for lane, light in scene["dynamic_map_states"].items()
    }
    for drive in drives:
        of, ego = drive.rsplit("_", 1)
        if of == name:
            write(out, drive, ego, scene["tracks"], lights, scene["map_features"])


def place(p):
    return [p["x"], p["y"], p["z"]] if "z" in p else [p["x"], p["y"]]


def features(roads):
    """`map_features` by id."""
    found = {}
    for k, road in enumerate(roads):
        kind, element = road["type"], road.get("map_element_id")
        geometry = road["geometry"] if isinstance(road["geometry"], list) else [road["geometry"]]
        points = np.array([place(p) for p in geometry], float)
        key = str(road.get("id", k))
        while key in found:
            key += "x"
        if kind == "lane" and len(points) > 1:
            unknown = "LANE_SURFACE_STREET" if element is None else "LANE_UNKNOWN"
            found[key] = {"type": LANES.get(element, unknown), "polyline": points}
        elif kind == "road_line":
            line = "UNKNOWN_LINE" if element is None else f"ROAD_LINE_{LINES.get(element, 'UNKNOWN')}"
            found[key] = {"type": line, "polyline": points}
        elif kind == "road_edge":
            found[key] = {"type": f"ROAD_EDGE_{'MEDIAN' if element == 16 else 'BOUNDARY'}", "polyline": points}
        elif kind in {"crosswalk", "speed_bump", "driveway"}:
            found[key] = {"type": kind.upper(), "polygon": points}
        elif kind == "stop_sign":
            found[key] = {"type": "STOP_SIGN", "position": points[0]}
    return found


def in_degrees(objects):
    """True if the headings agree better with the velocities when they are taken for degrees."""

    def error(unit):
        errors = [
            abs(math.remainder(heading * unit - math.atan2(v["y"], v["x"]), 2 * math.pi))
            for o in objects
            if o["type"] == "vehicle"
            for heading, v, valid in zip(o["heading"], o["velocity"], o["valid"])
            if valid and math.hypot(v["x"], v["y"]) > MOVING_MPS
        ]
        return float(np.median(errors)) if errors else math.inf

    return error(math.pi / 180) < error(1)


def tracks(objects):
    """`tracks` by id; rows without an observation are zero, as ScenarioNet has them."""
    unit = math.pi / 180 if in_degrees(objects) else 1
    found = {}
    for k, o in enumerate(objects):
        valid = np.array(o["valid"][:STEPS], bool)
        position = np.array([(place(p) + [0.0])[:3] for p in o["position"][:STEPS]], float)
        heading = np.remainder(np.array(o["heading"][:STEPS], float) * unit + math.pi, 2 * math.pi) - math.pi
        velocity = np.array([[v["x"], v["y"]] for v in o["velocity"][:STEPS]], float)
        for rows in (position, heading, velocity):
            rows[~valid] = 0
        sizes = {key: np.where(valid, o.get(key, 1.6), 0.0) for key in ("length", "width", "height")}
        state = {"position": position, "heading": heading, "velocity": velocity, "valid": valid, **sizes}
        key, kind = str(o.get("id", k)), KINDS.get(o["type"], "OTHER")
        metadata = {"track_length": STEPS, "type": kind, "object_id": key, "dataset": "waymo"}
        found[key] = {"type": kind, "state": state, "metadata": metadata}
    return found


def lights(states):
    """`dynamic_map_states` by lane; unknown in steps that are not mentioned."""
    found = {}
    for lane, light in states.items():
        shown = ["LANE_STATE_UNKNOWN"] * STEPS
        for step, state in zip(light["time_index"], light["state"]):
            if 0 <= step < STEPS:
                shown[step] = f"LANE_STATE_{state.upper()}"
        stop = np.array([light["x"][0], light["y"][0], (light.get("z") or [0.0])[0]], float)
        found[str(lane)] = {
            "type": "TRAFFIC_LIGHT",
            "state": {"object_state": shown},
            "lane": str(lane),
            "stop_point": stop,
            "metadata": {"track_length": STEPS, "type": "TRAFFIC_LIGHT", "object_id": str(lane), "dataset": "waymo"},
        }
    return found


def write(out, name, ego, all_tracks, all_lights, map_features):
    """Writes the part of the scene in which the ego is seen."""
    seen = np.flatnonzero(all_tracks[ego]["state"]["valid"])
    first, end = int(seen[0]), int(seen[-1]) + 1

    def part(item):
        state = {key: rows[first:end] for key, rows in item["state"].items()}
        return item | {"state": state, "metadata": item["metadata"] | {"track_length": end - first}}

    cut = {key: part(track) for key, track in all_tracks.items()}
    scenario = {
        "id": name,
        "version": "waymo 1.2",
        "length": end - first,
        "tracks": {key: track for key, track in cut.items() if track["state"]["valid"].any()},
        "dynamic_map_states": {key: part(light) for key, light in all_lights.items()},
        "map_features": map_features,
        "metadata": {
            "dataset": "waymo", "scenario_id": name, "id": name, "ts": np.arange(end - first) * STEP_S,
            "sdc_id": ego, "coordinate": "waymo", "metadrive_processed": False, "timestep": STEP_S,
        },
    }
    (out / f"sd_waymo_{name}.pkl").write_bytes(pickle.dumps(scenario, protocol=4))


if __name__ == "__main__":
    main()
