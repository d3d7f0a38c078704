"""What a policy is worth where a body is touched anywhere. Usage: touch_study.py FOREFEEL [--loads L,L] [--seconds S]
                                                     [--bodies A,B] [--paths A,B] [--seeds N] [--policies A,B]

Two hard bodies (a slab with a stiff lump; a liver of St. Venant-Kirchhoff material, which folds), palpation and raster,
and loads under the virtual clock with 2 workers: a solve takes `load` times what the hand needs for two spacings. A row
holds, over the seeds: the share of first visits within the just noticeable difference, and its gain over `nothing`; the
p95 of the error of the samples, and the geometric mean of its ratio to that of `nothing`; states solved. Intervals are
95 %, paired by seed (Student). `nothing` solves nothing in time: what is left for a policy to gain. `all` knows every
state that any policy of this case solved, from the start; clairvoyant-greedy knows the motion: the ceilings.

Measured with 3 to 4 seeds and loads 1 to 5: `coverage` and its placebo `shuffled` do the same, within the intervals, in
every cell. Over the lump the field of jets at rest is within the just noticeable difference everywhere, and states
take the p95 from 0.5 to 0.2 % (palpation) and from 1.4 to 0.95 % (raster) under any policy. On the St.
Venant-Kirchhoff liver knowing the way gains (palpation: p95 0.48 of that without states at load 1), labels do not."""
import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import tempfile

SPACING, SPEED, WORKERS = 0.006, 0.06, 2
LIVER = """[body]
phantom = "liver"
elements = 1800
fine = false
[material]
law = "st-venant-kirchhoff"
young = 5000.0
poisson = 0.4
"""
SLAB = """[body]
phantom = "slab"
fine = false
[[material]]
law = "neo-hookean"
young = 5000.0
poisson = 0.45
[[material]]
group = "lump"
law = "neo-hookean"
young = 50000.0
poisson = 0.45
"""
TOUCH = """[clamp]
group = "clamp"
[contact]
anywhere = true
radius = 0.02
pad = 1000.0
friction = 0.3
[state_space]
spacing = %g
depth = %g
tolerance = 0.02
[session]
workers = %d
"""
BODIES = {"lump": (SLAB, 0.024, ",where=0/0/0.04/0.03"), "st-venant-kirchhoff": (LIVER, 0.02, "")}
STUDENT = {2: 12.71, 3: 4.30, 4: 3.18, 5: 2.78, 6: 2.57, 7: 2.45, 8: 2.36, 10: 2.26}


def session(program, folder, scene, name, device, seconds, seed, policy, cost, states):
    run = f"{folder}/{name}"
    command = [program, "session", scene, "--device", device, "--clock", "virtual", "--seconds", str(seconds), "--seed",
               str(seed), "--policy", policy, "--cost", f"constant:{cost}", "-o", run, "--json", "--quiet"]
    if states:
        command += ["--states", states]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout), f"{run}/states.csv"


def united(files, path):
    """One table of all rows, each state once; columns that a file lacks are empty."""
    rows, columns = {}, []
    for file in files:
        with open(file, newline="") as table:
            for row in csv.DictReader(line for line in table if not line.startswith("#")):
                columns += [c for c in row if c not in columns]
                rows[tuple(row[c] for c in ("sx", "sy", "sz", "x", "y", "z"))] = row
    with open(path, "w", newline="") as out:
        writer = csv.DictWriter(out, columns)
        writer.writeheader()
        writer.writerows(rows.values())
    return path if rows else None


def interval(values):
    if len(values) < 2:
        return float("nan")
    return STUDENT.get(len(values), 2.0) * statistics.stdev(values) / math.sqrt(len(values))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--loads", default="1,2,5")
    parser.add_argument("--seconds", type=float, default=12)
    parser.add_argument("--bodies", default=",".join(BODIES))
    parser.add_argument("--paths", default="palpation,raster")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--policies", default="nearest,direction,coverage,shuffled,error,worth,worth-shuffled,"
                        "clairvoyant-greedy")
    given = parser.parse_args()
    print("body | path | load | policy | first visits within the JND | against nothing | p95 of the error | "
          "against nothing | states")
    for body in given.bodies.split(","):
        material, depth, where = BODIES[body]
        for path in given.paths.split(","):
            for load in map(float, given.loads.split(",")):
                cost = load * WORKERS * SPACING / SPEED
                cases = {policy: [] for policy in ["nothing", *given.policies.split(","), "all"]}
                for seed in range(1, given.seeds + 1):
                    with tempfile.TemporaryDirectory() as folder:
                        scene = f"{folder}/scene.toml"
                        with open(scene, "w") as out:
                            out.write(material + TOUCH % (SPACING, depth, WORKERS))
                        device = f"path:{path},speed={SPEED},depth={0.8 * depth}{where}"
                        known = []
                        for policy in cases:
                            states = united(known, f"{folder}/all.csv") if policy == "all" else None
                            real = "nearest" if policy in ("nothing", "all") else policy
                            summary, table = session(given.program, folder, scene, policy, device, given.seconds, seed,
                                                     real, 1e5 if policy in ("nothing", "all") else cost, states)
                            if os.path.getsize(table) > 0:
                                known.append(table)
                            cases[policy].append(summary)
                def shares(runs):
                    return [summary["error"]["first_visit"]["within_jnd"] or 0 for summary in runs]

                def worst(runs):
                    return [max(summary["error"]["samples"]["p95"] or 0, 1e-6) for summary in runs]

                nothing = cases["nothing"]
                for policy, runs in cases.items():
                    gains = [a - b for a, b in zip(shares(runs), shares(nothing))]
                    ratios = [math.log(a / b) for a, b in zip(worst(runs), worst(nothing))]
                    middle, half = statistics.mean(ratios), interval(ratios)
                    ratio = f"{math.exp(middle):.2f} ({math.exp(middle - half):.2f} to {math.exp(middle + half):.2f})"
                    solved = statistics.mean(s["states"]["solved"] + s["states"]["jets"] for s in runs)
                    print(f"{body} | {path} | {load:g} | {policy} | {100 * statistics.mean(shares(runs)):.1f} % | "
                          f"{100 * statistics.mean(gains):+.1f} +- {100 * interval(gains):.1f} | "
                          f"{100 * statistics.median(worst(runs)):.2f} % | "
                          f"{ratio} | {solved:.0f}", flush=True)


main()
