"""A question of the bench in NumPy, in the way of RefAV: for each track, each related object is brought into the
track's frame, then a loop over time stamps tests it, with the distance of the boxes computed one by one. Reads objects
from a CSV file (object, class, frame, x, y, heading, length, width); prints the seconds that the answer took."""

import csv
import sys
import time

import numpy as np


def box(x, y, h, length, width):
    c, s = np.cos(h), np.sin(h)
    local = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array([length, width]) / 2
    return local @ np.array([[c, s], [-s, c]]) + np.array([x, y])


def to_segment(p, a, b):
    ab = b - a
    t = np.clip(np.dot(p - a, ab) / np.dot(ab, ab), 0, 1)
    return np.linalg.norm(a + t * ab - p)


def distance(p, q):
    ends = [(k, l) for k in range(4) for l in range(4)]
    return min(min(to_segment(p[k], q[l], q[(l + 1) % 4]), to_segment(q[k], p[l], p[(l + 1) % 4])) for k, l in ends)


def main():
    question, objects = int(sys.argv[1]), {}
    with open(sys.argv[2], newline="") as file:
        for n, kind, _, *numbers in csv.reader(file):
            objects.setdefault(n, (kind, []))[1].append([float(v) for v in numbers])
    objects = [(kind, np.array(rows)) for kind, rows in objects.values()]
    related = [o for o in objects if o[0] == ["bicycle", "car", "pedestrian"][question]]
    start = time.perf_counter()
    for kind, track in objects:
        if question != 1 and kind != "car":
            continue
        counts = np.zeros(len(track), dtype=int)
        for _, other in related:
            if other is track:
                continue
            d = other[:, :2] - track[:, :2]
            c, s = np.cos(track[:, 2]), np.sin(track[:, 2])
            x, y = d[:, 0] * c + d[:, 1] * s, d[:, 1] * c - d[:, 0] * s
            for i in range(len(track)):
                length, width = track[i, 3:5]
                if question == 0 and not (abs(x[i]) <= length / 2 and y[i] < -width / 2):
                    continue
                if question == 2 and abs(np.arctan2(y[i], x[i])) > np.deg2rad(22.5):
                    continue
                if distance(box(*track[i]), box(*other[i])) <= (10 if question == 1 else 50):
                    counts[i] += 1
        counts >= (2 if question == 1 else 1)
    print(time.perf_counter() - start)


main()
