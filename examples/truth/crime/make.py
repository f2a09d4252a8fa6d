#!/usr/bin/env python3
"""Headway, time headway, TTC, DST, ALongReq and BTN of pairs by commonroad-crime: `python3 make.py > crime.csv`.

Needs `pip install commonroad-crime==0.4.5`. The scene is a straight lane along x, which is where its definitions and ours agree
(its HW adds half a length to both coordinates, which a lane along x does not notice). 200 and 300 keep their speed, 400 speeds up. 500
brakes: there CriMe is wrong, because it drops the sign of the other vehicle's acceleration (TTC, ALongReq: a root of a square); the
row is kept to show it. For a vehicle that draws away (300) its DST and ALongReq are those of one that comes nearer as fast.
"""

import numpy as np
from commonroad.geometry.shape import Rectangle
from commonroad.prediction.prediction import TrajectoryPrediction
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad.scenario.state import CustomState, InitialState
from commonroad.scenario.trajectory import Trajectory
from commonroad_crime.data_structure.configuration import CriMeConfiguration
from commonroad_crime.measure import BTN, DST, HW, THW, TTC, ALongReq

DT_S = 0.1
# CriMe looks for the time headway on the recorded trajectory: long enough that the ego gets there.
STEPS = 60
# Id, x of the box center (m), speed (m/s), acceleration (m/s2), length (m), width (m).
VEHICLES = [(100, 0.0, 15.0, 0.0, 4.6, 1.8), (200, 45.0, 10.0, 0.0, 12.0, 2.4), (300, 30.0, 17.0, 0.0, 2.2, 0.9),
            (400, 25.0, 8.0, 1.0, 4.6, 1.8), (500, 75.0, 14.0, -2.0, 4.6, 1.8)]


def vehicle(number, x, speed, accel, length, width):
    shape = Rectangle(length, width)
    def state(i):
        t = DT_S * i
        values = dict(time_step=i, position=np.array([x + speed * t + accel * t * t / 2, 0.0]), orientation=0.0,
                    velocity=speed + accel * t, velocity_y=0.0, acceleration=accel, acceleration_y=0.0, yaw_rate=0.0, slip_angle=0.0)
        # The first must be of its own class, which has no sideways values; CriMe asks for them all the same.
        found = InitialState(**{k: v for k, v in values.items() if k[-2:] != "_y"}) if i == 0 else CustomState(**values)
        found.velocity_y = found.acceleration_y = 0.0
        return found

    rest = Trajectory(1, [state(i) for i in range(1, STEPS)])
    return DynamicObstacle(number, ObstacleType.CAR, shape, state(0), TrajectoryPrediction(rest, shape))


def configuration():
    """The scene, as CriMe takes it."""
    scenario = Scenario(DT_S, ScenarioID.from_benchmark_id("ZAM_Straight-1_1_T-1", "2020a"))
    xs = np.arange(-100.0, 401.0, 5.0)
    # A ten-thousandth off the axis: ALongReq takes a direction of exactly 0 for "no direction" and answers 0.
    line = lambda y: np.column_stack([xs, y + 1e-4 * xs])
    scenario.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(line(1.75), line(0.0), line(-1.75), 1)]))
    for v in VEHICLES:
        scenario.add_objects(vehicle(*v))
    scenario.assign_obstacles_to_lanelets()
    config = CriMeConfiguration()
    config.update(ego_id=100, sce=scenario)
    return config


def main():
    config = configuration()
    print("step,other,hw_m,thw_s,ttc_s,dst_mps2,a_long_req_mps2,btn")
    for other in (200, 300, 400, 500):
        for step in range(0, 30, 3):
            values = [m(config).compute(other, step, verbose=False) for m in (HW, THW, TTC, DST, ALongReq, BTN)]
            print(f"{step},{other}," + ",".join(f"{v:.4f}" for v in values))


if __name__ == "__main__":
    main()
