"""What cars and people are told during the bundled drives, by time. The rest is SUMO's own car following.

Each script gets the TraCI module and the time in seconds before the step, at every step. Lanes are counted
from the right. A script keeps what it has begun in `state`, a dictionary that is empty when the drive starts.
"""

import math

# TraCI speed modes: all checks, and without regard to a safe speed (a driver who has not seen it yet).
ATTENTIVE, UNAWARE = 31, 30
# TraCI lane-change modes: only when told, and SUMO's own choice.
WHEN_TOLD, OWN_CHOICE = 0, 1621


def bumper_gap_m(traci, behind, ahead):
    """Distance along x between two vehicles on the straight; positions are those of the front bumpers."""
    vehicle = traci.vehicle
    return vehicle.getPosition(ahead)[0] - vehicle.getLength(ahead) - vehicle.getPosition(behind)[0]


def signal_junction(traci, t, state):
    """Nothing: lights, routes and departure times make this drive."""


def multilane(traci, t, state):
    """An urgent cut-in by a car, a slow one by a lorry, then the ego overtakes the lorry and meets a bend."""
    vehicle = traci.vehicle
    if t == 0.1:
        for name in ("ego", "lead", "cutter", "right_hand", "lorry"):
            vehicle.setLaneChangeMode(name, WHEN_TOLD)
        for name, speed_mps in (("lead", 17), ("cutter", 18), ("right_hand", 14.5), ("lorry", 14)):
            vehicle.setSpeed(name, speed_mps)
    if t == 8.0:  # the lead leaves to the right and slows; the ego speeds up
        vehicle.changeLane("lead", 0, 120)
    if t == 11.0:
        vehicle.setSpeed("lead", 13.5)
    if t == 12.0:
        vehicle.setSpeed("cutter", 12.5)

    # The car comes in front of the ego 23 m ahead and slower; the ego's driver needs 0.8 s to see it.
    if t > 14.0 and "cut" not in state and bumper_gap_m(traci, "ego", "cutter") < 23:
        state["cut"] = t
        vehicle.changeLane("cutter", 1, 60)
        vehicle.setSpeedMode("ego", UNAWARE)
        vehicle.setSpeed("ego", vehicle.getSpeed("ego"))
    if "cut" in state and t == round(state["cut"] + 0.8, 1):
        vehicle.setSpeed("ego", -1)
        vehicle.setSpeedMode("ego", ATTENTIVE)
    if "cut" in state and t == round(state["cut"] + 4.0, 1):
        vehicle.setSpeed("cutter", 22)
        vehicle.setSpeedMode("cutter", UNAWARE)

    # The lorry comes in from the right with room to spare; the ego follows it, then chooses to pass.
    if t > 20.0 and "lorry" not in state:
        if bumper_gap_m(traci, "lorry", "cutter") > 12 and bumper_gap_m(traci, "ego", "lorry") < 36:
            state["lorry"] = t
            vehicle.changeLane("lorry", 1, 120)
    if "lorry" in state and t == round(state["lorry"] + 7.0, 1):
        vehicle.setParameter("ego", "laneChangeModel.lcOvertakeRight", "0")
        vehicle.setLaneChangeMode("ego", OWN_CHOICE)
    if t == 36.0:
        vehicle.setSpeed("cutter", -1)
        vehicle.setSpeedMode("cutter", ATTENTIVE)


# People who cross where there is no crosswalk: when they step off, from where to where (x, y in meters in
# the network's own coordinates). SUMO's cars do not see them, so the ego is told to slow and when to go on.
JAYWALKERS = {
    "straight_over": (3.6, (103.0, 4.8), (103.0, -4.8)),
    "slantwise": (24.1, (276.0, -4.8), (285.5, 4.8)),
}
WALKING_MPS = 1.35


def walk(traci, name, t):
    """Puts a person on the straight line of its crossing; before and after it stands at the curb."""
    begins, (x0, y0), (x1, y1) = JAYWALKERS[name]
    length_m = math.hypot(x1 - x0, y1 - y0)
    share = min(max((t - begins) * WALKING_MPS / length_m, 0.0), 1.0)
    angle = math.degrees(math.atan2(x1 - x0, y1 - y0)) % 360  # clockwise from north, as SUMO has it
    traci.person.moveToXY(name, "", x0 + share * (x1 - x0), y0 + share * (y1 - y0), angle, keepRoute=2)


def back_street(traci, t, state):
    """Two people cross away from crosswalks; between them a junction straight on, after them a right turn."""
    if t < 0.1:
        return
    for name in JAYWALKERS:
        walk(traci, name, t)
    for begins, speed_mps, over_s, ends in ((5.5, 2.0, 3.0, 10.5), (25.5, 2.5, 2.5, 31.0)):
        if t == begins:
            traci.vehicle.slowDown("ego", speed_mps, over_s)
        if t == round(begins + over_s, 1):
            traci.vehicle.setSpeed("ego", speed_mps)
        if t == ends:
            traci.vehicle.setSpeed("ego", -1)
