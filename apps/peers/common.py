"""What the scripts of this folder share: the solver, test places, baselines, models and the table.

Each script places states with a sampler that other people use, by the interface of forefeel.Placement: ask(1) gives a
position (1, 3) [m], tell(x, force, stiffness) takes a state. Its predict(points), if any, is the model "own" of the
table, beside Forefeel's "cubic" (of forces), "hermite" (r^5, also of stiffnesses) and "jets" (energy jets of order 4).

    python3 SCRIPT.py [SCENE ...] [--states 64 125] [--seeds 3] [--set KEY.PATH=VALUE] [--alone] > table.csv
    python3 SCRIPT.py --check      # what was published of the method; ends with 1 if it does not hold

p95_percent is of |force - exact| / max(|exact|, 0.05 N) at 400 places. Seconds are of the CPU. --alone: no baselines.
"""
import argparse
import csv
import itertools
import pathlib
import sys
import tempfile
import time

import numpy as np

import designs

MODELS = {"cubic": {"kernel": "cubic", "data": "force"}, "hermite": {"kernel": "quintic", "data": "force+stiffness"}}


def run(make, solve, n):
    """n states of a sampler, the sampler, seconds of planning and of solving."""
    started, solving, states = time.process_time(), 0.0, []
    sampler = make(n)
    while len(states) < getattr(sampler, "pool", n):
        x = sampler.ask(1)
        asked = time.process_time()
        states.append(solve(x))
        solving += time.process_time() - asked
        sampler.tell(x[0], states[-1]["force"][0], states[-1]["stiffness"][0])
    states = np.concatenate(states)
    states = states[sampler.chosen(states, n)] if hasattr(sampler, "pool") else states
    return states, sampler, time.process_time() - started - solving, solving


def jets(ff, scene, keys, at, places):
    """Forces (m, 3) at places by jets at the same positions: a list for `generate`, then `evaluate`."""
    with tempfile.TemporaryDirectory() as folder:
        names = "at.csv", "asked.csv", "known.states", "forces.csv"
        known, asked, states, forces = (f"{folder}/{name}" for name in names)
        for file, positions in (known, at), (asked, places):
            np.savetxt(file, positions, delimiter=",", header="x,y,z", comments="")
        keys = [*keys, f"state_space.design='list:{known}'", "state_space.jet=4"]
        ff.command("generate", scene.file, *(word for key in keys for word in ("--set", key)), "--quiet", "-o", states)
        ff.command("evaluate", states, "--points", asked, "--data", "jet", "--no-bars", "--quiet", "-o", forces)
        return np.loadtxt(forces, delimiter=",", skiprows=1, usecols=(3, 4, 5))


def rows(scene, ff, samplers, args):
    body, (low, high), converged = scene.body, scene.box, ff.status_names.index("converged")

    def solve(x):
        states = body.solve(x, spacing=scene.spacing)
        if np.any(states["status"] != converged):
            sys.exit(f"{scene.file}: a state of its box did not converge, expected a smaller state_space.box")
        return states

    places = np.random.default_rng(0).uniform(low, high, (400, 3))
    exact = solve(places)["force"]
    size = np.maximum(np.linalg.norm(exact, axis=1), 0.05)
    settled = set()    # samplers that draw nothing: one seed says all
    for (name, make), n, seed in itertools.product(samplers.items(), args.states, range(args.seeds)):
        if name in settled and seed:
            continue
        states, sampler, planning, solving = run(lambda n: make(low, high, seed, n), solve, n)
        settled |= set() if getattr(sampler, "random", False) else {name}
        known = states["at"], states["force"], places, states["stiffness"]
        made = {model: ff.evaluate(*known, method="rbf", **options) for model, options in MODELS.items()}
        made["jets"] = jets(ff, scene, args.set, states["at"], places)
        made |= {"own": sampler.predict(places)} if hasattr(sampler, "predict") else {}
        for model, force in made.items():
            p95 = 100 * np.percentile(np.linalg.norm(force - exact, axis=1) / size, 95)
            yield name, pathlib.Path(scene.file).stem, model, n, f"{p95:.3g}", f"{planning:.3g}", f"{solving:.3g}", seed


def main(samplers, check):
    """samplers: name -> make(low, high, seed, n). check(): (what, value, "<" or ">", bound) for each claim."""
    parser = argparse.ArgumentParser()
    folder = pathlib.Path(__file__).resolve().parent.parent / "scenes"
    parser.add_argument("scenes", nargs="*", default=[folder / "liver.toml", folder / "beam.toml"], metavar="SCENE")
    parser.add_argument("--set", action="append", default=["body.fine=false"], metavar="KEY.PATH=VALUE")
    parser.add_argument("--states", nargs="+", type=int, default=[64, 125], metavar="N")
    parser.add_argument("--seeds", type=int, default=3)
    for flag in "--alone", "--check":
        parser.add_argument(flag, action="store_true")
    args = parser.parse_args()
    if args.check:
        held = []
        for what, value, relation, bound in check():
            held.append(value < bound if relation == "<" else value > bound)
            print(f"{'holds ' if held[-1] else 'FAILED'} {what}: {value:.4g}, expected {relation} {bound:.4g}")
        sys.exit(not all(held))
    ff = designs.need("forefeel")
    if not args.alone:
        if any(round(n ** (1 / 3)) ** 3 != n for n in args.states):
            parser.error("--states: expected cubes for the lattice, such as 64, or --alone")
        samplers = designs.baselines() | samplers
    out = csv.writer(sys.stdout)
    out.writerow(["sampler", "body", "model", "states", "p95_percent", "planning_s", "solving_s", "seed"])
    try:
        for scene in args.scenes:
            out.writerows(rows(ff.Scene(scene, args.set), ff, samplers, args))
    except ff.InputError as problem:
        print(problem, file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":    # the baselines alone
    main({}, lambda: [])
