"""Energy that the hand gains on closed paths. Usage: closed_loops.py FOREFEEL STATES.csv [--loops N] [--reach METRE]

Each point of a path gets the model of its own neighbours, as in a session without the damped switch. Printed for energy
jets and for force and stiffness: |sum f . dx| over sum |f . dx| of N smooth loops (default 100) around rest. STATES.csv:
states with jets, as `generate --set state_space.jet=4` and `export` write them. Needs NumPy."""
import argparse
import os
import subprocess
import tempfile

import numpy

POINTS = 256  # of a loop; a sum over equal steps is exact for a smooth one
MODELS = {"jets, 8": ["--data", "jet"],
          "Hermite r5, 25": ["--data", "force+stiffness", "--kernel", "quintic", "--neighbours", "25"],
          "Hermite r3, 25": ["--data", "force+stiffness", "--kernel", "cubic", "--neighbours", "25"]}


def loop(source, reach):
    """Places and their derivatives along a closed path of two harmonics."""
    angle = numpy.arange(POINTS) * 2 * numpy.pi / POINTS
    centre, size = source.uniform(-reach, reach, 3), 0.5 * reach * source.normal(size=(2, 2, 3))
    at, along = numpy.tile(centre, (POINTS, 1)), numpy.zeros((POINTS, 3))
    for k, (cosine, sine) in enumerate(size, 1):
        at += (numpy.outer(numpy.cos(k * angle), cosine) + numpy.outer(numpy.sin(k * angle), sine)) / k
        along += numpy.outer(numpy.cos(k * angle), sine) - numpy.outer(numpy.sin(k * angle), cosine)
    return at, along


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("forefeel")
    parser.add_argument("states")
    parser.add_argument("--loops", type=int, default=100)
    parser.add_argument("--reach", type=float, default=0.012)
    args = parser.parse_args()
    source = numpy.random.default_rng(5)
    loops = [loop(source, args.reach) for _ in range(args.loops)]
    with tempfile.TemporaryDirectory() as folder:
        points, forces = os.path.join(folder, "q.csv"), os.path.join(folder, "f.csv")
        numpy.savetxt(points, numpy.vstack([at for at, _ in loops]), delimiter=",", header="x,y,z", comments="",
                      fmt="%.17g")
        for name, options in MODELS.items():
            subprocess.run([args.forefeel, "evaluate", args.states, "--points", points, "-o", forces, "--no-bars",
                            "--quiet", *options], check=True)
            force = numpy.loadtxt(forces, delimiter=",", skiprows=1, usecols=(3, 4, 5))
            shares = []
            for i, (_, along) in enumerate(loops):
                work = (force[i * POINTS:(i + 1) * POINTS] * along).sum(1)
                shares.append(abs(work.sum()) / numpy.abs(work).sum())
            print(f"{name:<15} net over gross: median {numpy.median(shares):.1e}, p95 {numpy.quantile(shares, 0.95):.1e}, "
                  f"max {max(shares):.1e}")


main()
