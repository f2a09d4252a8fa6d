"""Writes examples/table/following: 4 s of a van behind a car that brakes, from formulas, so that every number can be checked.

The same drive as another fleet would record it is written into examples/table_fleet/following: columns in cm, km/h and
degrees, axes north-east-down, compass headings, milliseconds since 1970, numbers for words. Its mapping file is
examples/table_fleet/fleet.yaml.

The van's pose is that of its rear axle, 20 times a second; the objects are seen 10 times a second. All along x (east).
  van   axle x(t) = 8 t                         8 m/s throughout
  car   x(t) = 30 + 10 t - t^2 / 2, y = 0       10 m/s, braking at 1 m/s2
  ped   x = 60, y(t) = -6 + 1.5 t               1.5 m/s, seen from 1.0 s to 3.0 s, and not from 2.1 s to 2.6 s
"""

import csv
import datetime
import pathlib

here = pathlib.Path(__file__).parent / "following"
fleet = pathlib.Path(__file__).parent.parent / "table_fleet" / "following"


def write(name, header, rows, folder=here, delimiter=","):
    with open(folder / name, "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n", delimiter=delimiter)
        w.writerow(header)
        w.writerows(rows)


def number(v):
    return f"{v:.6g}"


write(
    "ego.csv",
    ["time_s", "x_m", "y_m", "heading_rad", "speed_mps", "brake", "gear", "turn_signal", "bus_speed_mps"],
    [[number(k / 20), number(8 * k / 20), 0, 0, 8, "true" if k >= 40 else "false", "D", "off", 7.9] for k in range(81)],
)
objects = []
for k in range(41):
    t = k / 10
    objects.append([number(t), "car-1", "car", number(30 + 10 * t - t * t / 2), 0, 0, number(10 - t), 4.5, 1.8, 1.5])
    if 10 <= k <= 30 and not 21 <= k <= 25:
        objects.append([number(t), "ped-1", "pedestrian", 60, number(-6 + 1.5 * t), 1.570796, 1.5, 0.6, 0.6, 1.7])
write(
    "objects.csv",
    ["time_s", "track_id", "class", "x_m", "y_m", "heading_rad", "speed_mps", "length_m", "width_m", "height_m"],
    objects,
)
write(
    "lanes.csv",
    ["lane_id", "centre_xyz_m", "left_xyz_m", "right_xyz_m", "left_mark", "right_mark", "left_neighbour", "successors",
     "kind", "in_junction", "speed_limit_mps"],
    [
        ["east-1", "-20 0; 100 0", "-20 1.75; 100 1.75", "-20 -1.75; 100 -1.75", "dashed", "solid", "east-2", "", "vehicle",
         "false", 13.89],
        ["east-2", "", "-20 5.25; 100 5.25", "-20 1.75; 100 1.75", "solid", "dashed", "", "", "vehicle", "false", 13.89],
    ],
)
write(
    "areas.csv",
    ["area_id", "kind", "boundary_xyz_m", "lane_ids"],
    [
        ["zebra", "crosswalk", "58 -4; 62 -4; 62 8; 58 8", ""],
        ["line-1", "stop_line", "56 -1.75; 56 1.75", "east-1"],
        ["bump", "speed_bump", "90 -1.75; 90 5.25", ""],
    ],
)
write(
    "lights.csv",
    ["time_s", "lane_id", "colour"],
    [[0, "east-1", "green"], [1.5, "east-1", "yellow"], [4, "east-1", "red"]],
)
write("context.csv", ["time_s", "kind", "value", "source"], [[0, "weather", "rain", "wiper"]])

# The same as another fleet would record it. North is y, east is x; a car along x heads 90 degrees on the compass.
START_MS = int(datetime.datetime(2026, 1, 15, 10, 30, tzinfo=datetime.timezone.utc).timestamp() * 1000)


def comma(v):
    return f"{v:.9g}".replace(".", ",")


def line(text):
    """A line of the layout, as north and east in cm."""
    points = [point.split() for point in text.split(";") if point.strip()]
    return "; ".join(f"{100 * float(y):.9g} {100 * float(x):.9g}" for x, y in points)


write(
    "2026-01-15_pose.csv",
    ["stamp", "north", "east", "yaw", "v", "v_wheels", "pedal", "gear", "blinker", "wheel", "gps_fix"],
    # The blinker is unknown (255) in the first row; the wheel is 10 degrees to the left all along, right is positive.
    [
        [START_MS + 50 * k, 0, 40 * k, 90, comma(3.6 * 8), comma(3.6 * 7.9), int(k >= 40), 4, 0 if k else 255, -10, 3]
        for k in range(81)
    ],
    fleet,
    ";",
)
objects = []
for k in range(41):
    t = k / 10
    east, speed = 30 + 10 * t - t * t / 2, 3.6 * (10 - t)
    objects.append([START_MS + 100 * k, 1, "PKW", 0, comma(100 * east), 90, comma(speed), 450, 180])
    if 10 <= k <= 30 and not 21 <= k <= 25:
        north = -6 + 1.5 * t
        objects.append([START_MS + 100 * k, 2, "7", comma(100 * north), 6000, 0, comma(3.6 * 1.5), 60, -1])
write(
    "2026-01-15_objects.csv",
    ["stamp", "id", "label", "north", "east", "yaw", "v", "length", "width"],
    objects,
    fleet,
    ";",
)
write(
    "lanes.csv",
    ["lane_id", "middle", "left", "right", "left_mark", "right_mark", "left_neighbour", "limit"],
    [
        ["east-1", line("-20 0; 100 0"), line("-20 1.75; 100 1.75"), line("-20 -1.75; 100 -1.75"), "dashed", "solid", "east-2",
         50],
        ["east-2", "", line("-20 5.25; 100 5.25"), line("-20 1.75; 100 1.75"), "solid", "dashed", "NULL", 50],
    ],
    fleet,
    ";",
)
