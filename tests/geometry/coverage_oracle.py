#!/usr/bin/python3
"""Spread, hull membership and gamma of a CSV against SciPy (qhull). Exit 77 where SciPy is absent.
usage: coverage_oracle.py STATES.csv QUERIES.csv   (queries: x,y,z,spread,gamma_cos,radius)"""
import sys

try:
    import numpy as np
    from scipy.spatial import ConvexHull, Delaunay
except ImportError:
    sys.exit(77)

states = np.loadtxt(sys.argv[1], delimiter=",")
queries = np.loadtxt(sys.argv[2], delimiter=",")
delaunay = Delaunay(states)
checked = bad = 0
for x, y, z, spread, cosine, radius in queries:
    q = np.array([x, y, z])
    cell = int(delaunay.find_simplex(q[None])[0])
    if (cell >= 0) != np.isfinite(spread):
        bad += 1
        print("hull", q, spread)
    if cell >= 0 and np.isfinite(spread):
        t = delaunay.transform[cell]
        w = t[:3] @ (q - t[3])
        w = np.append(w, 1 - w.sum())
        pi = np.sqrt(w @ ((states[delaunay.simplices[cell]] - q) ** 2).sum(1))
        if abs(pi - spread) > 1e-8 * pi:
            bad += 1
            print("spread", q, spread, pi)
    d = states - q
    r = np.linalg.norm(d, axis=1)
    u = (d[r <= radius].T / r[r <= radius]).T
    if len(u) >= 4:
        least = (-ConvexHull(u).equations[:, 3]).min()
        if (least > 1e-7 or cosine > 1e-7) and abs(least - cosine) > 1e-8:
            bad += 1
            print("gamma", q, cosine, least)
    checked += 1
print(checked, "checked,", bad, "wrong")
sys.exit(1 if bad or checked == 0 else 0)
