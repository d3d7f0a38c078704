"""Time of a million labels and a million forces from Python, beside the same loop in C++.

    PYTHONPATH=build/release/apps/python /usr/bin/python3 tests/bench/python_speed.py [NUMBER [REPEATS]]

Each ratio is the median over repeats of Python's time over that of the loop run right after it, with the same threads.
The loop reads and writes C++ vectors.
"""
import statistics
import sys
import time

import numpy as np

import forefeel as ff

number = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 7

random = np.random.default_rng(1)
axis = np.arange(-6, 7) * 0.006                                # [m]
at = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
force = -300 * at - 2e5 * at * (at ** 2).sum(axis=1, keepdims=True)
space = ff.StateSpace(ff.measured(at, force), spacing=0.006)
models = {"force, cubic, 100 states": space.model_at([0, 0, 0], kernel="cubic", neighbours=100),
          "force, cubic, 25 states": space.model_at([0, 0, 0], kernel="cubic", neighbours=25)}
points = random.uniform(-0.04, 0.04, (number, 3))
cases = [("label", space.label, space._space._loop_seconds)]
cases += [(name, model.force, model._loop_seconds) for name, model in models.items()]
for name, call, loop in cases:
    pairs = []
    for _ in range(repeats + 1):                               # the first warms up
        start = time.perf_counter()
        call(points)
        pairs.append((time.perf_counter() - start, loop(points)))
    mine, theirs = (statistics.median(times) for times in zip(*pairs[1:]))
    ratio = statistics.median(a / b for a, b in pairs[1:])
    print(f"{name}: Python {1e9 * mine / number:.1f} ns a point, C++ loop {1e9 * theirs / number:.1f} ns, ratio {ratio:.2f}")
