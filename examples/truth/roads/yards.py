"""Drives across a yard or car park without lanes; and, without an answer, past one that lies beside an ordinary road."""

from along import Layout


def drives(draw):
    for i, across in enumerate(draw.sample([True, True, True, False], 4)):
        yield f"yard{i:02}", across


def build(name, across, draw, work):
    b = Layout(name, draw)
    s0 = b.straight(draw.uniform(60, 90))
    s1 = b.road.length
    if across:
        b.area("parking", s0, s1, -draw.uniform(10, 16), draw.uniform(10, 16))
        b.drive.undrawn = (f"e{len(b.road.pieces) - 1}",)
        b.order(s0 - 4, s1 + 2, draw.uniform(3, 5), decel=1.6)
        b.note("inside", "reactive_road.geometry_adaptation.unstructured", s0, s1)
    else:
        b.area("parking", s0, s1, -24, -3)
    return b.finish(work)
