"""How often the interval of the discretisation error holds the truth. Usage: interval_of_truth.py FOREFEEL [SURFACE]
                                                      [--fine N] [--truth N] [--positions N] [--bodies A,B]

Eight bodies with a pad of 1000 N/m and 20 mm: linear elements (1,800) with a fine body of FINE quadratic elements
(default 1,800), against solved quadratic bodies of TRUTH elements (default 10 FINE, so less than half the size, and
another mesh than the one that the tool compares with), both small at the pad, at positions drawn in a ball of 24 mm. SURFACE: a file of a closed surface for the body `organ`, else left out.
Positions whose truth has no equilibrium are counted. An hour with the defaults."""
import argparse
import json
import math
import random
import statistics
import subprocess
import tempfile

BODIES = {  # phantom, law, Poisson's ratio, place of the pad
    "liver": ("liver", "neo-hookean", 0.45, ""),
    "ball": ("ball", "neo-hookean", 0.45, ""),
    "slab": ("slab", "neo-hookean", 0.45, ""),
    "beam": ("beam", "neo-hookean", 0.45, ""),
    "organ": (None, "neo-hookean", 0.45, "nearest = [-0.1184, 0.1261, 0.0672]"),
    "stiff in volume": ("liver", "neo-hookean", 0.49, ""),
    "mooney": ("slab", "mooney-rivlin", 0.4, "nearest = [0.05, 0.03, 0.04]"),
    "other lobe": ("liver", "stable-neo-hookean", 0.4, "nearest = [-0.05, 0.0, 0.1]"),
}
FARTHEST, NEAREST = 0.024, 0.004  # [m]


def scene(folder, name, element, elements, fine, surface):
    phantom, law, poisson, place = BODIES[name]
    body = f'phantom = "{phantom}"' if phantom else f'mesh = "{surface}"\nlength = 0.22'
    clamp = 'clamp.group = "clamp"' if phantom else 'clamp.below = { axis = "z", share = 0.3 }'
    path = f"{folder}/{element}{elements}.toml"
    with open(path, "w") as out:
        out.write(f"""{clamp}
[body]
{body}
element = "{element}"
elements = {elements}
fine = {"{ elements = %d }" % fine if fine else "false"}
[material]
law = "{law}"
young = 5000.0
poisson = {poisson}
[contact]
{place}
pad = 1000.0
radius = 0.02
[state_space]
spacing = 0.012
box = [[-0.03, -0.03, -0.03], [0.03, 0.03, 0.03]]
""")
    return path


def drawn(name, count):
    source, points = random.Random("truth-" + name), []
    while len(points) < count:
        x = [source.uniform(-FARTHEST, FARTHEST) for _ in range(3)]
        if NEAREST < math.hypot(*x) < FARTHEST:
            points.append(x)
    return points


def solved(program, path, points, *more):
    at = ["--at=%r,%r,%r" % tuple(x) for x in points]
    return json.loads(subprocess.run([program, "solve", path, "--json", "--quiet", *at, *more], check=False,
                                     capture_output=True, text=True).stdout)["states"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("surface", nargs="?")
    parser.add_argument("--fine", type=int, default=1800)
    parser.add_argument("--truth", type=int)
    parser.add_argument("--positions", type=int, default=20)
    parser.add_argument("--bodies", default=",".join(BODIES))
    given = parser.parse_args()
    all_inside, all_said, widths = 0, 0, []
    for name in given.bodies.split(","):
        if name == "organ" and not given.surface:
            continue
        with tempfile.TemporaryDirectory() as folder:
            points = drawn(name, given.positions)
            truths = solved(given.program, scene(folder, name, "quadratic", given.truth or 10 * given.fine, 0,
                                                 given.surface), points)
            states = solved(given.program, scene(folder, name, "linear", 1800, given.fine, given.surface), points,
                            "--discretisation-error")
        errors, inside, said, none = [], 0, 0, 0
        for state, truth in zip(states, truths):
            if not truth["converged"]:
                none += 1
                continue
            error = (math.dist(state["force"], truth["force"]) / math.hypot(*truth["force"])
                     if state["converged"] else 1.0)
            errors.append(error)
            low, high = state["discretisation_interval"]
            if low is None or high is None:
                continue
            said += 1
            inside += low <= error <= high
            widths.append((high - low) / error)
        all_inside, all_said = all_inside + inside, all_said + said
        errors.sort()
        print(f"{name}: error p50 {100 * statistics.median(errors):.2f} %, max {100 * errors[-1]:.2f} %; an interval "
              f"said for {said} of {len(errors)}, it holds {inside}; {none} without a truth", flush=True)
    print(f"all: {all_inside} of {all_said} inside; median of width over truth {statistics.median(widths):.2f}")


main()
