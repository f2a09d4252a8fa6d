"""Seconds that rtamt takes for `eventually[0:10] always[0:5] (x < 3)` over a number of samples (argument 1), the fastest of
three, then the robustness of each sample."""

import math
import sys
import time

import rtamt

n = int(sys.argv[1])
x = [5.0 + 4.0 * math.sin(i * 0.37) + 2.0 * math.cos(i * 0.011) for i in range(n)]
best, out = math.inf, None
for _ in range(3):
    spec = rtamt.StlDiscreteTimeSpecification()
    spec.declare_var("x", "float")
    spec.spec = "eventually[0:10](always[0:5](x < 3))"
    spec.parse()
    start = time.perf_counter()
    out = spec.evaluate({"time": list(range(n)), "x": x})
    best = min(best, time.perf_counter() - start)
print(best)
for _, robustness in out:
    print(robustness)
