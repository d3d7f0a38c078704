"""Scores of error bars over bodies and motions: the prior of approx/error/prior_scores.cpp, and how well bars cover.

    /usr/bin/python3 tests/bench/error_bar_prior.py prior [SECONDS]    # prints the rows of prior_scores.cpp
    /usr/bin/python3 tests/bench/error_bar_prior.py check [SECONDS]    # how well bars cover, on other motions

SECONDS: of each session, 10 unless given. Runs build/release/apps/forefeel under the virtual clock. A score is
sqrt(max(0, e^2 - r^2)) / s: e is the distance of the rendered force from that of a tight solve, r what the switch
holds back, s the scale in frames.csv.
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

SHARES = [0.05, 0.25, 0.5, 0.7, 0.8, 0.85, 0.9, 0.925, 0.95, 0.96, 0.97, 0.975, 0.98, 0.985, 0.99, 1.0]
LABELS = ["safe", "sparse", "gap", "blank"]
LEVELS = {"bar90": 0.90, "bar95": 0.95, "bar99": 0.99}
BODIES = {
    "liver neo-Hookean": ["body.phantom=liver"],
    "liver St. Venant-Kirchhoff": ["body.phantom=liver", "material.law=st-venant-kirchhoff", "material.poisson=0.3"],
    "liver Mooney-Rivlin, stiff": ["body.phantom=liver", "material.law=mooney-rivlin", "material.young=20000.0"],
    "beam stable neo-Hookean": ["body.phantom=beam", "material.law=stable-neo-hookean"],
    "ball neo-Hookean 0.49": ["body.phantom=ball", "material.poisson=0.49"],
    "slab neo-Hookean": ["body.phantom=slab", "material.poisson=0.3"],
    "liver, one node": ["body.phantom=liver", "contact={nearest=[0.0,0.0,1.0]}"],
}
OUTSIDE = {  # of the prior: for check alone
    "beam Mooney-Rivlin": ["body.phantom=beam", "material.law=mooney-rivlin"],
    "slab St. Venant-Kirchhoff": ["body.phantom=slab", "material.law=st-venant-kirchhoff", "material.poisson=0.3"],
}
MOTIONS = {"prior": ["tour", "line", "lissajous"], "check": ["reach", "circle", "palpation", "press,tremor=0.0002"]}
COSTS = ["constant:0.05", "lognormal:0.2,0.5"]


def run(body, motion, cost, seconds, folder):
    """The sampled frames of a session: dictionaries of floats and the label."""
    name = "press,speed=0.05," + motion.split(",")[1] if "," in motion else motion + ",speed=0.05"
    command = ["build/release/apps/forefeel", "session", "apps/scenes/liver.toml", "--clock", "virtual", "--quiet",
               "--threads", "1", "--seconds", str(seconds), "--device", "path:" + name, "--cost", cost,
               "-o", str(folder / f"{abs(hash((body, motion, cost)))}")]
    for key in BODIES[body]:
        command += ["--set", key]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        print(f"{body}, {motion}, {cost}: {done.stderr.strip()}", file=sys.stderr)
        return []
    with open(pathlib.Path(command[-1 - 2 * len(BODIES[body])]) / "frames.csv") as file:
        return [row for row in csv.DictReader(file) if row["sampled"] == "1" and row["error"]]


def vector(row, name):
    """The three columns name_x or namex, ..."""
    return [float(row[name + axis]) for axis in "xyz"]


def score(row):
    """Score of a frame; None where it has no bar."""
    if not row["bar_scale"]:
        return None
    force, plain, truth = vector(row, "rendered_"), vector(row, "u"), vector(row, "r")
    error2 = sum((a - b) ** 2 for a, b in zip(force, truth))
    held2 = sum((a - b) ** 2 for a, b in zip(force, plain))
    return math.sqrt(max(0.0, error2 - held2)) / float(row["bar_scale"])


def all_runs(kind, seconds):
    if kind == "check":
        BODIES.update(OUTSIDE)
    jobs = [(b, m, c) for b in BODIES for m in MOTIONS[kind] for c in COSTS]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        rows = pool.map(lambda job: run(*job, seconds, pathlib.Path(folder)), jobs)
        return list(zip(jobs, rows))


def print_prior(runs):
    for label in LABELS:
        scores = sorted(z for _, rows in runs for row in rows if row["label"] == label and (z := score(row)) is not None)
        print(f"// {label}: {len(scores)} scores")
        if scores:
            ranks = [scores[min(len(scores) - 1, max(0, math.ceil(share * len(scores)) - 1))] for share in SHARES]
            print("{{" + ", ".join(f"{rank:.3g}" for rank in ranks) + "}},")


def print_check(runs):
    def line(name, rows):
        rows = [row for row in rows if row["bar95"]]
        if not rows:
            return
        errors = sorted(math.dist(vector(row, "rendered_"), vector(row, "r")) for row in rows)
        widths = sorted(float(row["bar95"]) for row in rows)
        p95 = errors[math.ceil(0.95 * len(errors)) - 1]
        inside = [sum(math.dist(vector(row, "rendered_"), vector(row, "r")) <= float(row[bar]) for row in rows)
                  / len(rows) for bar in LEVELS]
        print(f"{name:30} {len(rows):6} samples  inside 90/95/99 %: " + " ".join(f"{100 * s:5.1f}" for s in inside)
              + f"  median width {widths[len(widths) // 2]:.3g} N, {widths[len(widths) // 2] / p95:.2f} of the p95 error")

    line("all", [row for _, rows in runs for row in rows])
    for label in LABELS:
        line(label, [row for _, rows in runs for row in rows if row["label"] == label])
    for body in BODIES:
        line(body, [row for job, rows in runs for row in rows if job[0] == body])


if __name__ == "__main__":
    kind = sys.argv[1] if len(sys.argv) > 1 else ""
    if kind not in MOTIONS:
        sys.exit("error_bar_prior.py: expected prior or check")
    (print_prior if kind == "prior" else print_check)(all_runs(kind, float(sys.argv[2]) if len(sys.argv) > 2 else 10))
