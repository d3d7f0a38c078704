#!/usr/bin/env python3
"""Compares `forefeel evaluate` on measured forces with SciPy's kernels and a Gaussian process.

  measured_matrix.py FOREFEEL [--cells 120] [--seed 1] [--rows 100,1000,10000] [--points 300] [--only WORDS] [--few]

A cell is a set (stroke, curve, raster, presses, hold, random, lattice), a field (four smooth ones, one with a kink), the
noise of the force (a share of its root mean square) and of the positions [m], and a number of rows. The cells are drawn
by the seed. Points lie between the rows; beside a stroke, a curve or a press held they also lie up to 1 mm off, for the
bars alone. Errors are |f~ - f| [N] against the field without noise.

Peers: SciPy's default (thin plate, all rows, no smoothing), its linear kernel with 50 neighbours, the best in hindsight
of its kernels at 25, 50 and 200 neighbours and three smoothings, and up to 1,000 rows a Gaussian process with a nugget
(scikit-learn). Prints a row a cell and a summary; --few prints the summary of the small form that the test runs.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from scipy.interpolate import RBFInterpolator

warnings.filterwarnings("ignore")
size = 0.02  # half the side of the box [m]


# Fields [N] of a position [m].
def stiffening(x):
    return -60 * x * (1 + 1500 * np.sum(x * x, axis=1, keepdims=True))


def waves(x):
    return np.c_[np.sin(120 * x[:, 0]) * np.cos(90 * x[:, 1]), np.sin(100 * x[:, 1] + 60 * x[:, 2]),
                 2 * np.cos(80 * x[:, 2]) * np.cos(70 * x[:, 0])]


def pressed(x):
    return np.c_[-40 * x[:, 0], -40 * x[:, 1] * (1 + 10 * x[:, 0]), 2 * np.exp(-60 * x[:, 2])]


def lump(x):
    away = x - np.array([0.006, -0.004, -0.005])
    bump = np.exp(-np.sum(away * away, axis=1, keepdims=True) / (2 * 0.008**2))
    return -100 * x + 250 * away * bump


def kink(x):
    depth = np.maximum(0, -x[:, 2:] - 0.004 * np.sin(100 * x[:, :1]))
    return np.c_[-20 * x[:, 0], 30 * np.abs(x[:, 1]), 300 * depth[:, 0]]


fields = {f.__name__: f for f in (stiffening, waves, pressed, lump, kink)}


def turn(random):
    q, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def sphere_curve(t):
    """A winding curve on a sphere of radius 0.03 m about (0, 0, -0.02), t from 0 to 1."""
    polar, around = 0.5 * np.sin(2 * np.pi * t), 2.5 * (t - 0.5)
    return np.c_[0.03 * np.sin(around) * np.cos(polar), 0.03 * np.sin(polar), 0.03 * np.cos(around) * np.cos(polar) - 0.02]


def stroke(t):
    return np.c_[2 * size * (t - 0.5), 0.3 * size * (t - 0.5), np.full_like(t, -0.004)]


def between(rows, random, count, jitter):
    pick = rows[random.integers(len(rows), size=count)]
    return pick + jitter * random.normal(size=pick.shape)


def make_set(name, n, random, points):
    """Positions (n, 3), points inside (points, 3), and points beside a line (or none)."""
    none = np.zeros((0, 3))
    beside = lambda on: on + np.exp(random.uniform(np.log(5e-5), np.log(1e-3), (len(on), 1))) * (
        lambda d: d / np.linalg.norm(d, axis=1, keepdims=True))(random.normal(size=on.shape))
    if name in ("stroke", "curve"):
        path = stroke if name == "stroke" else sphere_curve
        on = path(random.uniform(0.01, 0.99, points))
        return path(np.linspace(0, 1, n)), on, beside(path(random.uniform(0.05, 0.95, points)))
    if name == "raster":
        lines = {100: 9, 1000: 21, 10000: 36}.get(n, 21)
        across, deep = (lines // 3, 3)
        each = n // lines
        y, z = np.meshgrid(np.linspace(-1, 1, across), np.linspace(-1, 0, deep))
        at = np.concatenate([np.c_[np.linspace(-size, size, each), np.full(each, a * size), np.full(each, 0.4 * b * size)]
                             for a, b in zip(y.ravel(), z.ravel())])
        low = [-1, -1, -0.4]
        return at, size * random.uniform(low, [1, 1, 0], (points, 3)), none
    if name == "presses":
        deep = 10 if n <= 1000 else 40
        side = int(np.sqrt(n / deep))
        g = np.linspace(-size, size, side)
        x, y, z = np.meshgrid(g, g, np.linspace(-0.01, 0, deep), indexing="ij")
        at = np.c_[x.ravel(), y.ravel(), z.ravel()]
        at[:, :2] += np.repeat(0.1 * size / side * random.normal(size=(side * side, 2)), deep, axis=0)
        return at, np.c_[random.uniform(-0.95 * size, 0.95 * size, (points, 2)), random.uniform(-0.01, 0, points)], none
    if name == "hold":  # pressed in steps at some places and held at each depth
        held = 10 if n <= 1000 else 40
        deep = 5
        places = random.uniform(-size, size, (max(2, n // (held * deep)), 2))
        at = np.array([[x, y, -0.01 * (k + 1) / deep] for x, y in places for k in range(deep) for _ in range(held)])
        at = at + 2e-7 * random.normal(size=at.shape)
        weights = random.dirichlet(np.ones(3), points)
        corners = at[random.integers(len(at), size=(points, 3))]
        return at, np.einsum("pk,pkd->pd", weights, corners), none
    if name == "random":
        low, high = [-size, -size, -size], [size, size, 0]
        return random.uniform(low, high, (n, 3)), random.uniform(low, high, (points, 3)), none
    if name == "lattice":
        side = round((2 * n)**(1 / 3))
        g, d = np.linspace(-size, size, side), np.linspace(-size, 0, max(2, side // 2))
        x, y, z = np.meshgrid(g, g, d, indexing="ij")
        return np.c_[x.ravel(), y.ravel(), z.ravel()], random.uniform([-size, -size, -size], [size, size, 0], (points, 3)), none
    raise ValueError(name)


sets = ["stroke", "curve", "raster", "presses", "hold", "random", "lattice"]


def draw_cells(count, seed, rows):
    random = np.random.default_rng(seed)
    every = [(s, f, n, e, p) for s in sets for f in fields for n in rows for e in (0, 0.001, 0.01, 0.05)
             for p in (0, 1e-6, 2e-5)]
    return [every[i] for i in random.permutation(len(every))[:count]]


def cell_data(cell, seed, points):
    name, field, n, noise, shaken = cell
    random = np.random.default_rng([seed, sets.index(name), list(fields).index(field), n, int(1e4 * noise), int(1e7 * shaken)])
    at, inside, beside = make_set(name, n, random, points)
    q = turn(random)
    f = fields[field]
    truth = lambda x: f(x) @ q.T
    forces = truth(at)
    rms = np.sqrt(np.mean(np.sum(forces**2, axis=1)))
    forces = forces + noise * rms / np.sqrt(3) * random.normal(size=forces.shape)
    where = at + shaken * random.normal(size=at.shape)
    order = random.permutation(len(at))
    return (where @ q.T)[order], forces[order], inside @ q.T, truth(inside), beside @ q.T, truth(beside)


def errors_of(field, points, truth):
    return np.linalg.norm(field(points) - truth, axis=1)


def scipy_errors(at, forces, points, truth, **options):
    try:
        return errors_of(RBFInterpolator(at, forces, **options), points, truth)
    except (np.linalg.LinAlgError, ValueError):
        return None


def gaussian_process(at, forces, points, truth):
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    scale = at.std()
    spread = forces.std()
    kernel = ConstantKernel(1.0, (1e-3, 1e6)) * RBF(1.0, (1e-2, 1e2)) + WhiteKernel(1e-4, (1e-12, 1e1))
    process = GaussianProcessRegressor(kernel, n_restarts_optimizer=0, random_state=0)
    middle = forces.mean(axis=0)
    process.fit(at / scale, (forces - middle) / spread)
    return np.linalg.norm(process.predict(points / scale) * spread + middle - truth, axis=1)


def peers(at, forces, points, truth, process=True, most_all=4000):
    """Errors at each point: default, linear50, and every other by name."""
    unique, index = np.unique(at, axis=0, return_index=True)
    forces, at = forces[index], unique
    found = {}
    if len(at) <= most_all:
        found["default"] = scipy_errors(at, forces, points, truth)
    found["linear50"] = scipy_errors(at, forces, points, truth, kernel="linear", neighbors=50)
    for kernel in ("linear", "thin_plate_spline", "cubic", "quintic"):
        for neighbours in (25, 50, 200):
            for smoothing in (0, 1e-3, 1e-1):  # in units of the kernel at the spacing of the neighbours
                s = smoothing * {"linear": 0.005, "thin_plate_spline": 2.5e-5, "cubic": 1.25e-7, "quintic": 3e-12}[kernel]
                found[f"{kernel}{neighbours}/{smoothing:g}"] = scipy_errors(
                    at, forces, points, truth, kernel=kernel, neighbors=min(neighbours, len(at)), smoothing=s)
    if process and len(at) <= 1000:
        try:
            found["process"] = gaussian_process(at, forces, points, truth)
        except (ImportError, np.linalg.LinAlgError, ValueError):
            pass
    return {k: v for k, v in found.items() if v is not None}


def run_forefeel(program, at, forces, points, extra=()):
    with tempfile.TemporaryDirectory() as folder:
        states, asked = Path(folder) / "states.csv", Path(folder) / "points.csv"
        np.savetxt(states, np.c_[at, forces], delimiter=",", header="x,y,z,fx,fy,fz", comments="", fmt="%.17g")
        np.savetxt(asked, points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
        begin = time.time()
        done = subprocess.run([program, "evaluate", str(states), "--points", str(asked), "--json", *extra],
                              capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        found = json.loads(done.stdout)
        found["seconds"] = time.time() - begin
        return found


def bars_of(found):
    return np.array([np.inf if b is None else b for b in found.get("bar95", [])], dtype=float)


def within(at, points):
    """Of each point, whether the hull of the rows holds it; all, if the rows span no volume."""
    from scipy.spatial import Delaunay, QhullError
    try:
        return Delaunay(at).find_simplex(points) >= 0
    except QhullError:
        return np.full(len(points), True)


def p95(errors):
    return float(np.quantile(errors, 0.95))


def interval(ours, theirs, random, draws=400):
    """Paired bootstrap interval (95 %) of the ratio of p95."""
    picks = random.integers(len(ours), size=(draws, len(ours)))
    ratios = np.quantile(ours[picks], 0.95, axis=1) / np.maximum(np.quantile(theirs[picks], 0.95, axis=1), 1e-300)
    return np.quantile(ratios, [0.025, 0.975])


def kept_peers(folder, cell, seed, points, *data):
    """peers(), kept in a file of `folder`: they do not change with Forefeel, and a process takes minutes."""
    if not folder:
        return peers(*data)
    name, field, n, noise, shaken = cell
    file = Path(folder) / f"{name}-{field}-{n}-{noise:g}-{shaken:g}-{seed}-{points}.npz"
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savez(file, **{k.replace("/", "|"): v for k, v in peers(*data).items()})
    return {k.replace("|", "/"): v for k, v in np.load(file).items()}


def judge(program, cell, seed, points, process=True, with_peers=True, keep=""):
    at, forces, inside, truth, beside, truth_beside = cell_data(cell, seed, points)
    found = run_forefeel(program, at, forces, inside)
    made, bars, n = np.array(found["forces"]), bars_of(found), len(inside)
    if len(beside):
        asked = run_forefeel(program, at, forces, beside)
        made, bars = np.r_[made, np.array(asked["forces"])], np.r_[bars, bars_of(asked)]
    ours = np.linalg.norm(made[:n] - truth, axis=1)
    off = np.linalg.norm(made[n:] - truth_beside, axis=1)
    among = bars[:n][within(at, inside)] if len(beside) == 0 and within(at, inside).any() else bars[:n]
    floor = 1e-9 * np.sqrt(np.mean(np.sum(truth**2, axis=1)))
    out = {"cell": cell, "p95": p95(ours), "expected": found["expected_error"]["p95"] if found["expected_error"] else None,
           "held": np.mean(ours <= bars[:n]), "width": float(np.median(bars[:n])) / max(p95(ours), floor),
           "spread": float(np.max(among) / max(np.min(among), 1e-300)), "seconds": found["seconds"],
           "beside": np.mean(off <= bars[n:]) if len(off) else np.nan, "off": p95(off) if len(off) else np.nan,
           "chosen": found["chosen"]}
    if with_peers:
        theirs = kept_peers(keep, cell, seed, points, at, forces, inside, truth, process)
        best = min(theirs, key=lambda k: p95(theirs[k]))
        ratio = lambda name: (max(p95(ours), floor) / max(p95(theirs[name]), floor)) if name in theirs else np.nan
        out.update(default=ratio("default"), linear50=ratio("linear50"), best=ratio(best), name=best,
                   interval=interval(ours, theirs[best], np.random.default_rng(0)))
    return out


def line(r):
    name, field, n, noise, shaken = r["cell"]
    c = r["chosen"] or {}
    how = f"{c.get('kernel')}/{'all' if c.get('all_states') else c.get('neighbours')}/{c.get('ridge', 0):.0e}" if c else "-"
    low, high = r.get("interval", (np.nan, np.nan))
    return (f"{name:8} {field:10} {n:6} {100 * noise:4.1f}% {1e6 * shaken:3.0f}um p95 {r['p95']:9.3g} N  default {r.get('default', np.nan):6.2f}"
            f"  linear50 {r.get('linear50', np.nan):6.2f}  best {r.get('best', np.nan):6.2f} [{low:.2f} {high:.2f}] {r.get('name', ''):25}"
            f" held {100 * r['held']:5.1f}% width {r['width']:7.2f} spread {r['spread']:8.1f} beside {100 * r['beside']:5.1f}%"
            f" off {r['off']:8.2g} expected {r['expected'] or np.nan:8.2g} {r['seconds']:5.1f} s  {how}")


def summary(results):
    column = lambda key: np.array([r.get(key, np.nan) for r in results], dtype=float)
    best = column("best")
    text = [f"{len(results)} cells"]
    for key in ("default", "linear50"):
        values = column(key)
        text.append(f"{key}: worst ratio {np.nanmax(values):.2f}, above 1.05 in {np.nansum(values > 1.05):.0f} of {np.sum(np.isfinite(values))}")
    text.append(f"best in hindsight: median ratio {np.nanmedian(best):.2f}, worst {np.nanmax(best):.2f}, above 1.25 in "
                f"{np.nansum(best > 1.25):.0f}, above 2 in {np.nansum(best > 2):.0f}")
    held, beside = column("held"), column("beside")
    text.append(f"bars of 95 %: held inside from {100 * np.nanmin(held):.0f} to {100 * np.nanmax(held):.0f} %, median {100 * np.nanmedian(held):.1f} %, "
                f"in 93 to 97 % in {np.sum((held >= 0.93) & (held <= 0.97))}, below 93 % in {np.sum(held < 0.93)}; beside at least "
                f"{100 * np.nanmin(beside) if np.any(np.isfinite(beside)) else np.nan:.0f} %, below 93 % in {np.nansum(beside < 0.93):.0f}; width over 3 in "
                f"{np.nansum(column('width') > 3):.0f}; spread over 20 in {np.nansum(column('spread') > 20):.0f}")
    of_set = lambda name: [r for r in results if r["cell"][0] == name]
    text.append("held inside by set: " + ", ".join(
        f"{name} {100 * np.mean([r['held'] for r in of_set(name)]):.1f} % of {len(of_set(name))} cells"
        for name in sets if of_set(name)))
    above = lambda key, most: [" ".join(map(str, r["cell"])) + f" ({r[key]:.2f})" for r in results if r.get(key, 0) > most]
    for key, most in (("default", 1.05), ("linear50", 1.05), ("best", 1.25)):
        if above(key, most):
            text.append(f"{key} above {most}: " + "; ".join(above(key, most)))
    return "\n".join(text)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("--cells", type=int, default=120)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--rows", default="100,1000,10000")
    arguments.add_argument("--points", type=int, default=300)
    arguments.add_argument("--only", default="", help="cells whose line holds all of these words, as raster,kink")
    arguments.add_argument("--no-peers", action="store_true")
    arguments.add_argument("--keep", default="", help="folder that keeps the errors of the peers for the next run")
    arguments.add_argument("--no-process", action="store_true")
    arguments.add_argument("--json", default="")
    given = arguments.parse_args()
    words = [w for w in given.only.split(",") if w]
    results = []
    for cell in draw_cells(given.cells, given.seed, [int(n) for n in given.rows.split(",")]):
        if not all(w in map(str, cell) for w in words):
            continue
        results.append(judge(given.program, cell, given.seed, given.points, not given.no_process,
                             not given.no_peers, given.keep))
        print(line(results[-1]), flush=True)
    print(summary(results))
    if given.json:
        Path(given.json).write_text(json.dumps(results, default=lambda o: o.tolist() if hasattr(o, "tolist") else str(o)))


if __name__ == "__main__":
    sys.exit(main())
