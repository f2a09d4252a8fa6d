"""RefAV's functions on one Argoverse 2 log: `peer.py REFAV LOG [FUNCTION ...]`. REFAV is a checkout of
https://github.com/CainanD/RefAV, LOG a log folder whose annotations have the ego (`annotations_with_ego.feather` of the
scenario-mining challenge). For each line of docs/reference/refav.md that asks about objects: the function, CPU seconds, and
rows (object and time stamp) for which it holds. A function of pairs takes minutes: it is asked of every EACH-th vehicle (in
the order of ids) against all, since each is gone through by itself, and its seconds and rows are multiplied. One process; the log and its map are read, and the positions of all tracks
differentiated, before the clock starts; no answer comes from a cache of another question.

Needs `pip install --no-deps av2` with numpy, scipy, pandas, polars, pyarrow, opencv-python-headless, numba, pathos, tqdm and
the like; what only serves images and models (torch, transformers, kornia) is replaced by empty modules."""

import shutil
import sys
import tempfile
import time
import types
from importlib.machinery import ModuleSpec
from pathlib import Path

import numpy as np


EACH = 25
PAIRS = {"has_objects_in_relative_direction", "get_objects_in_relative_direction", "facing_toward", "heading_toward", "being_crossed_by",
         "near_objects", "following", "heading_in_relative_direction_to", "in_same_lane", "on_relative_side_of_road",
         "reverse_relationship"}


class Empty(types.ModuleType):
    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        # SciPy asks whether something is an instance of `torch.Tensor`.
        return type(name, (), {}) if name[0].isupper() else Empty(name)

    def __call__(self, *args, **kwargs):
        return self


class Absent:
    """Finds the modules that are replaced, with everything below them."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if name.split(".")[0] in ("torch", "transformers", "kornia", "av"):
            return ModuleSpec(name, Absent, is_package=True)
        return None

    @staticmethod
    def create_module(spec):
        return Empty(spec.name)

    @staticmethod
    def exec_module(module):
        module.__path__ = []


class Serial:
    """In place of a pool of processes, whose start would count as RefAV's time."""

    def __init__(self, nodes=1):
        del nodes

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False

    @staticmethod
    def map(work, items):
        return list(map(work, items))


def rows(scenario):
    """Objects and time stamps for which a scenario holds."""
    from refAV.utils import get_scenario_timestamps

    return sum(len(get_scenario_timestamps({uuid: related}) if isinstance(related, dict) else related)
               for uuid, related in scenario.items())


def questions(f, log):
    """Name, and the call, with the arguments of docs/reference/refav.md; objects are vehicles, as are related ones."""
    v = f.get_objects_of_category(log, category="VEHICLE")
    some = {uuid: v[uuid] for uuid in sorted(v)[::EACH]}
    return len(v) / len(some), {
        "get_objects_of_category": lambda: f.get_objects_of_category(log, category="BICYCLE"),
        "is_category": lambda: f.is_category(v, log, category="TRUCK"),
        "has_objects_in_relative_direction": lambda: f.has_objects_in_relative_direction(some, v, log, direction="left"),
        "get_objects_in_relative_direction": lambda: f.get_objects_in_relative_direction(some, v, log, direction="backward"),
        "turning": lambda: f.turning(v, log, direction="left"),
        "changing_lanes": lambda: f.changing_lanes(v, log),
        "has_lateral_acceleration": lambda: f.has_lateral_acceleration(v, log, min_accel=1, max_accel=9),
        "facing_toward": lambda: f.facing_toward(some, v, log, within_angle=22.5, max_distance=50),
        "heading_toward": lambda: f.heading_toward(some, v, log, angle_threshold=22.5, minimum_speed=0.5),
        "accelerating": lambda: f.accelerating(v, log, min_accel=0.65),
        "has_velocity": lambda: f.has_velocity(v, log, min_velocity=0.5),
        "at_pedestrian_crossing": lambda: f.at_pedestrian_crossing(v, log, within_distance=1),
        "on_lane_type": lambda: f.on_lane_type(v, log, lane_type="BIKE"),
        "near_intersection": lambda: f.near_intersection(v, log, threshold=5),
        "on_intersection": lambda: f.on_intersection(v, log),
        "being_crossed_by": lambda: f.being_crossed_by(some, v, log),
        "near_objects": lambda: f.near_objects(some, v, log, distance_thresh=10, min_objects=2),
        "following": lambda: f.following(some, v, log),
        "heading_in_relative_direction_to": lambda: f.heading_in_relative_direction_to(some, v, log, direction="opposite"),
        "stationary": lambda: f.stationary(v, log),
        "at_stop_sign": lambda: f.at_stop_sign(v, log),
        "in_drivable_area": lambda: f.in_drivable_area(v, log),
        "on_road": lambda: f.on_road(v, log),
        "in_same_lane": lambda: f.in_same_lane(some, v, log),
        "on_relative_side_of_road": lambda: f.on_relative_side_of_road(some, v, log, side="opposite"),
        "scenario_and": lambda: f.scenario_and([f.turning(v, log, direction="left"), f.near_intersection(v, log, threshold=5)]),
        "scenario_or": lambda: f.scenario_or([f.stationary(v, log), f.accelerating(v, log, min_accel=0.65)]),
        "scenario_not": lambda: f.scenario_not(f.stationary)(v, log),
        "reverse_relationship": lambda: f.reverse_relationship(f.near_objects)(some, v, log, distance_thresh=10),
    }


def main():
    refav, source, only = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
    sys.meta_path.insert(0, Absent)
    sys.path.insert(0, str(refav))
    import refAV.atomic_functions as f
    import refAV.utils as utils

    utils.Pool = Serial
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / source.name
        shutil.copytree(source, log)
        shutil.copy(log / "annotations_with_ego.feather", log / "sm_annotations.feather")
        # Where the log comes without the height of the ground it is flat: heights decide none of these questions.
        if not list((log / "map").glob("*_ground_height_surface____*.npy")):
            np.save(log / "map" / f"{source.name}_ground_height_surface____flat.npy", np.zeros((4000, 4000), np.float16))
        warm = {"get_map", "get_log_timestamps"}
        utils.get_map(log)
        share, asked = questions(f, log)
        for name, ask in asked.items():
            if only and name not in only:
                continue
            for cached, entries in utils.cache_manager.caches.items():
                if cached not in warm:
                    entries.clear()
            start = time.process_time()
            try:
                found = rows(ask())
            except Exception as error:  # a function that cannot answer is named, and the others go on
                print(name, "failed", type(error).__name__, str(error)[:200].replace("\n", " "), flush=True)
                continue
            times = share if name in PAIRS else 1
            print(name, f"{times * (time.process_time() - start):.4f}", round(times * found), flush=True)


if __name__ == "__main__":
    main()
