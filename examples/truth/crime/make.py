#!/usr/bin/env python3
"""Headway, time headway and TTC of one pair by commonroad-crime: `python3 make.py > crime.csv`.

Needs `pip install commonroad-crime==0.4.5`. The scene is a straight lane along x, which is where its definitions and ours agree
(its HW adds half a length to both coordinates, which a lane along x does not notice). Both vehicles keep their speed: its TTC takes
acceleration into account and drops the sign of the other vehicle's.
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
from commonroad_crime.measure import HW, THW, TTC

DT_S = 0.1
# CriMe looks for the time headway on the recorded trajectory: long enough that the ego gets there.
STEPS = 60
# Id, x of the box centre (m), speed (m/s), length (m), width (m).
VEHICLES = [(100, 0.0, 15.0, 4.6, 1.8), (200, 45.0, 10.0, 12.0, 2.4), (300, 30.0, 17.0, 2.2, 0.9)]


def vehicle(number, x, speed, length, width):
    shape = Rectangle(length, width)
    def state(i):
        values = dict(time_step=i, position=np.array([x + speed * DT_S * i, 0.0]), orientation=0.0, velocity=speed,
                    velocity_y=0.0, acceleration=0.0, acceleration_y=0.0, yaw_rate=0.0, slip_angle=0.0)
        # The first must be of its own class, which has no sideways values; CriMe asks for them all the same.
        found = InitialState(**{k: v for k, v in values.items() if k[-2:] != "_y"}) if i == 0 else CustomState(**values)
        found.velocity_y = found.acceleration_y = 0.0
        return found

    rest = Trajectory(1, [state(i) for i in range(1, STEPS)])
    return DynamicObstacle(number, ObstacleType.CAR, shape, state(0), TrajectoryPrediction(rest, shape))


def main():
    scenario = Scenario(DT_S, ScenarioID.from_benchmark_id("ZAM_Straight-1_1_T-1", "2020a"))
    xs = np.arange(-100.0, 401.0, 5.0)
    line = lambda y: np.column_stack([xs, np.full_like(xs, y)])
    scenario.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(line(1.75), line(0.0), line(-1.75), 1)]))
    for v in VEHICLES:
        scenario.add_objects(vehicle(*v))
    scenario.assign_obstacles_to_lanelets()
    config = CriMeConfiguration()
    config.update(ego_id=100, sce=scenario)
    print("step,other,hw_m,thw_s,ttc_s")
    for other in (200, 300):
        for step in range(0, 30, 3):
            values = [m(config).compute(other, step, verbose=False) for m in (HW, THW, TTC)]
            print(f"{step},{other}," + ",".join(f"{v:.4f}" for v in values))


if __name__ == "__main__":
    main()
