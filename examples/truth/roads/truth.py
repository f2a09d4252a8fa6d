"""What happened in a drive, from what was laid, what the driver was told and what the simulator logged: entries of `truth.jsonl`.

Nothing here comes from Whyroad's signals or rules; the moments are those of LABELING.md 4 and the taxonomy's conditions. Being in or
on something is meant of the car's middle, coming within so many meters of it of the front bumper. B is the first step in which the
car brakes for its order. Each kind of moment is one function below; the kinds are named where the features are laid.
"""

import math

START_NS = 1_767_225_600 * 10**9
HALF_M = 2.4          # from the front bumper to the car's middle
EYE_M, OBJECT_M = 1.2, 0.6  # over the road: a driver's eye, a car's tail light (AASHTO Green Book, chapter 3)


class Log:
    def __init__(self, drive):
        self.drive, self.rows = drive, drive.log
        self.last = self.rows[-1][0]

    def front(self, station):
        """When the front bumper comes to a station: the first step at or beyond it."""
        return next((r[0] for r in self.rows if r[1] >= station), self.last)

    def middle(self, station):
        return self.front(station + HALF_M)

    def brakes(self, order):
        """B, or None where the car never had to brake for the order."""
        return next((r[0] for r in self.rows if r[4] == order), None)

    def speed(self, t):
        return next(r[2] for r in self.rows if r[0] >= t)

    def lost(self, order):
        """How much slower the car went for its order, m/s."""
        run = [r[2] for r in self.rows if r[4] == order]
        return max(run) - min(run) if run else 0.0

    def out(self, station):
        """When the car's middle has left the junction that begins at a station."""
        after = next(r[1] for r in self.rows if r[1] > station + 3 and not r[3].startswith(":"))
        return self.middle(after)

    def halts(self, after):
        return next((r[0] for r in self.rows if r[0] >= after and r[2] < 0.3), None)

    def starts(self, after):
        """First step after `after` in which a standing car moves."""
        return next((b[0] for a, b in zip(self.rows, self.rows[1:]) if b[0] >= after and a[2] < 0.05 <= b[2]), None)


def acts(log, f):
    """A bend: from the earlier of 0.5 s before slowing and entry, until exit (LABELING.md 4, geometry_adaptation)."""
    start = min(log.brakes(f["order"]) - 0.5, log.middle(f["s0"]))
    return start, start, log.middle(f["s1"])


def inside(log, f):
    """The range in which the feature acts: on it."""
    return log.middle(f["s0"]), log.middle(f["s0"]), log.middle(f["s1"])


def holds(log, f):
    """As long as the log states it of the place where the car is: its station changes with the front bumper."""
    return log.front(f["s0"]), log.front(f["s0"]), log.front(f["s1"])


def seen(log, f):
    """From where it is perceivable, 50 m before it (taxonomy: within 50 m ahead), until it is passed."""
    start = log.front(f["s0"] - 50)
    return start, start, log.middle(f["s1"])


def during(log, f):
    """A state all around: from the later of its beginning and 3 s before the car slows for it, as long as it lasts (LABELING.md 4, L1
    default of reactive_road and its fallback)."""
    start = max(log.front(f["s0"]), log.brakes(f["order"]) - 3)
    return start, start, log.front(f["s1"])


def change(log, f):
    """The light changes; 3 s (taxonomy: within 3 s)."""
    start = log.front(f["s0"])
    return start, start, start + 3


def control(reach):
    """The later of entering the area that the rule controls and 0.5 s before slowing (LABELING.md 4, reactive_rule)."""
    def moment(log, f):
        key = max(log.front(f["s0"] - reach), log.brakes(f["order"]) - 0.5)
        return key, key, log.middle(f["s1"])
    return moment


def lower(log, f):
    """A lower limit: applies, or 0.5 s before slowing where that is earlier."""
    key = min(log.middle(f["s0"]), log.brakes(f["order"]) - 0.5)
    return key, key, log.middle(f["s0"]) + 3


def higher(log, f):
    """A higher limit applies and the car speeds up."""
    key = log.middle(f["s0"])
    return key, key, key + 3


def sight(log, f):
    """A bend whose inner side is built up: while less of the road is in sight than the car needs to stop (2 s and 3 m/s2; taxonomy)."""
    road, wall = f["road"], f["wall"]
    blind = []
    for t, s, v, *_ in log.rows:
        if not f["s0"] - 60 < s < f["s1"] + 10:
            continue
        at = s - HALF_M
        eye = road.at(at)[:2]
        need = 2 * v + v * v / 6
        if any(crosses(eye, road.at(at + d)[:2], wall) for d in range(2, int(need), 2)):
            blind.append(t)
    return (blind[0], blind[0], blind[-1] + 0.1) if blind else None


def crosses(a, b, outline):
    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    return any(side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
               for c, d in zip(outline, outline[1:] + outline[:1]))


def crest(log, f):
    """While the road's own profile hides some of the next 60 m."""
    road, blind = f["road"], []
    for t, s, *_ in log.rows:
        if not f["s0"] - 60 < s < f["s1"]:
            continue
        at = s - HALF_M
        eye = road.at(at)[2] + EYE_M
        heights = [(d, road.at(at + d)[2]) for d in range(1, 61)]
        steepest = -math.inf
        for d, z in heights:
            if (z + OBJECT_M - eye) / d < steepest:
                blind.append(t)
                break
            steepest = max(steepest, (z - eye) / d)
    return (blind[0], blind[0], blind[-1] + 0.1) if blind else None


def reach(log, f):
    """A hidden place within 7 m of the path: from where the car could be there in 6 s until it is passed (taxonomy)."""
    start = next(r[0] for r in log.rows if f["s0"] - r[1] <= 6 * r[2])
    return start, start, log.middle(f["s1"])


def gate(log, f):
    """The barrier rises (LABELING.md 4)."""
    key = log.drive.opens[f["order"]]
    return key, key, log.middle(f["s1"])


def waits(log, f):
    """Pulling up before the closed barrier: from slowing until it has stood for 1 s (taxonomy, pull_over)."""
    start = log.brakes(f["order"])
    return start, start, log.halts(start) + 1


def end(log, f):
    """A road that ends: from 50 m before its end (taxonomy: within 50 m ahead)."""
    start = log.front(f["s0"] - 50)
    return start, start, log.last


def stops(log, f):
    """At a light: the later of 0.5 s before slowing and its turning yellow or red (LABELING.md 4); until the halt."""
    key = max(log.brakes(f["order"]) - 0.5, f["turned"])
    return key, key, log.halts(key)


def resumes(log, f):
    """At a light: the later of 0.5 s before moving and its turning green (LABELING.md 4)."""
    key = max(log.starts(f["turned"]) - 0.5, f["turned"])
    return key, key, key + 3


def turned(log, f):
    """The light changes; until the line is crossed."""
    return f["turned"], f["turned"], log.front(f["s0"])


def enters(log, f):
    """The front bumper crosses into a marked area; until the halt there."""
    key = log.front(f["s0"])
    return key, key, log.halts(key)


def junction(log, f):
    """A blind junction: from 60 m before it until the car is there (LABELING.md 4: within 60 m)."""
    start = log.front(f["s0"] - 60)
    return start, start, log.front(f["s0"])


def passage(log, f):
    """Straight through a junction with nothing to mind: its entry, from 3 s before it until 2 s after it (LABELING.md 4, turn)."""
    return log.middle(f["s0"]) - 3, log.middle(f["s0"]), log.middle(f["s1"]) + 2


def across(log, f):
    """0.5 s before the car begins to move across (LABELING.md 4, reactive_rule's fallback); a change takes 3 s."""
    moves = log.front(f["s0"]) + 0.1
    return moves - 0.5, moves - 0.5, moves + 3


def arrow(log, f):
    """The later of coming within 60 m of the board and 0.5 s before moving across (LABELING.md 4, reactive_rule)."""
    moves = log.front(f["move"]) + 0.1
    key = max(log.front(f["s0"] - 60), moves - 0.5)
    return key, key, moves + 3


def choice(log, f):
    """Choosing a way at a junction: from slowing for it, within 60 m of it, until out of it (taxonomy, irregular_intersection)."""
    start = max(log.front(f["s0"] - 60), log.brakes(f["order"]))
    return start, start, log.out(f["s0"])


def guided(log, f):
    """On the guidance line, from the junction's edge until out of it (LABELING.md 4, reactive_rule)."""
    key = log.middle(f["s0"])
    return key, key, log.out(f["s0"])


def line(log, f):
    """The line changes (rule takes effect) and the car, which waited for it, changes lane."""
    key = log.middle(f["s0"])
    return key, key, key + 3


KINDS = {k.__name__: k for k in (acts, inside, holds, seen, during, change, lower, higher, sight, crest, reach, gate, waits, end, stops, resumes,
                                 turned, enters, junction, passage, across, arrow, choice, guided, line)}
KINDS |= {"control60": control(60), "control80": control(80), "control100": control(100)}
# An adjustment is one by 1 m/s or more (taxonomy); the order may have come while the car was slow already.
LEAST_MPS = 1.0
ANSWERS = {"acts", "inside", "holds", "during", "seen", "change", "control60", "control80", "control100", "lower", "sight", "crest", "reach", "junction", "choice"}


def entries(drive):
    """Entries of one drive; what the driver did not answer though he was told to is said on the way."""
    log = Log(drive)
    out = []
    for f in drive.features:
        if not f["leaf"] or f["s0"] > log.rows[-1][1] + 10:
            continue
        if f["kind"] in ANSWERS and f["order"] and log.lost(f["order"]) < LEAST_MPS:
            print(f"{drive.name}: no answer to {f['leaf']} at {f['s0']}: {log.lost(f['order']):.2f}")
            continue
        moments = KINDS[f["kind"]](log, f)
        if moments is None or any(m is None for m in moments):
            print(f"{drive.name}: {f['leaf']} at {f['s0']} did not happen")
            continue
        start, key, last = (START_NS + round(max(0.0, min(m, log.last)) * 10) * 10**8 for m in moments)
        out.append({"scenario_id": f["leaf"], "drive_id": drive.name, "start_ns": start, "keyframe_ns": key, "end_ns": max(last, key + 10**8)}
                   | ({"optional": True, "reason": f["optional"]} if "optional" in f else {}))
    return sorted(out, key=lambda e: (e["keyframe_ns"], e["scenario_id"]))


# Of these only the plain ones are listed: others may be in the drives too.
NOT_ALL = ["proactive.turn.straight"]
