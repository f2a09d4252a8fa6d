"""Drives through junctions of special shape: several exits to choose from, turns with guidance lines painted."""

from network import ARM_M, Cross, Net
from signs import Junctions

SHAPES = [("choice", True)] * 4 + [("choice", False)] + [("guided", True)] * 4 + [("guided", False)]


def drives(draw):
    todo = list(SHAPES)
    draw.shuffle(todo)
    for i, plan in enumerate(todo):
        yield f"shape{i:02}", plan


def build(name, plan, draw, work):
    shape, answers = plan
    b = Junctions(name, draw)
    if shape == "choice":
        slight = draw.choice([-1, 1]) * draw.uniform(27, 42)
        cross = Cross(arms=(slight, 90, -90), lanes=("slr",))
        onward = draw.choice(["straight", "slight"]) if answers else "straight"
    else:
        cross, onward = Cross(wide=4, into=0, lanes=("sl",)), "left"
    b.road.cross(cross)
    i = len(b.road.pieces)
    b.straight(draw.uniform(190, 240))
    drive = b.finish(work)
    b.net = Net(work)
    drive.mode = 7
    line = b.line(i)
    if shape == "choice":
        if answers:
            order = b.order(line - draw.uniform(2, 8), line + 6, b.slower(3.5, 5), decel=draw.uniform(1.1, 1.5))
            b.note("choice", "proactive.irregular_intersection.route_selection", line, line, order)
    else:
        b.order(line - 6, line + 36, draw.uniform(5, 6.5), decel=1.5)
        drive.rails = answers
        if answers:
            drive.guided = (f"n{i}",)
            b.note("guided", "reactive_rule.lane_rule.guidance_line", line, line)
    if onward != "straight":
        drive.route = [f"e{n}" for n in range(i)] + [f"out{i}_0"]
        drive.until = line + ARM_M - 15
    return drive
