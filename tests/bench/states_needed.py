"""How many states a model needs. Usage: states_needed.py FOREFEEL [--positions N] [--seconds T] [--bodies A,B]
                                                     [--picture FILE.svg] [MESH …]

For each body and each kind of data (jets of order 4; force and stiffness with r^5 and r^3): `generate --error 0.02`
places the states, without hindsight, for at most T seconds (default 120). The model of the first n of them is compared
with tight solves at N random positions in a ball (default 1000); a position without an equilibrium is counted, not
compared. Printed: the least n whose error at p95 is at most 7 and 2 %, and the solving time of these states. MESH:
volume meshes of organs, pressed at their upper side. --picture: error against states, a panel a body, by gnuplot."""
import argparse
import csv
import json
import math
import os
import random
import statistics
import subprocess
import tempfile

PAD = "pad = 1000.0\nradius = 0.02"
BODIES = {  # phantom, law, Poisson's ratio, contact, radius of the ball [m]
    "default": ("liver", "neo-hookean", 0.45, PAD, 0.036),
    "rigid patch": ("liver", "neo-hookean", 0.45, 'group = "contact"', 0.036),
    "one node": ("liver", "neo-hookean", 0.45, "nearest = [0.0, 0.0, 1.0]", 0.036),
    "beam": ("beam", "neo-hookean", 0.45, 'nearest = [1.0, 0.0, 0.0]', 0.030),
    "St. Venant-Kirchhoff": ("liver", "st-venant-kirchhoff", 0.45, PAD, 0.036),
    "lump": ("slab", "neo-hookean", 0.45, PAD, 0.024),
}
KINDS = {"jets": ("jet", "quintic"), "Hermite r5": ("force+stiffness", "quintic"), "Hermite r3": ("force+stiffness", "cubic"),
         "force r3": ("force", "cubic")}
INKS = ["#0072b2", "#d55e00", "#009e73", "#8a8a8a"]
COUNTS = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128, 160, 200, 256, 300]


def scene(folder, name, mesh):
    phantom, law, poisson, contact, radius = BODIES.get(name, (None, "neo-hookean", 0.45, "nearest = [0.0, 0.0, 1.0]\n" + PAD, 0.036))
    body = f'phantom = "{phantom}"' if phantom else f'mesh = "{os.path.abspath(mesh)}"'
    clamp = 'group = "clamp"' if phantom else 'below = { axis = "z", share = 0.15 }'
    materials = f'[[material]]\nlaw = "{law}"\nyoung = 5000.0\npoisson = {poisson}\n'
    if name == "lump":
        materials += f'[[material]]\ngroup = "lump"\nlaw = "{law}"\nyoung = 50000.0\npoisson = {poisson}\n'
    path = os.path.join(folder, name.replace("/", "_") + ".toml")
    with open(path, "w") as out:
        out.write(f"""{materials}[body]
{body}
fine = false
[clamp]
{clamp}
[contact]
{contact}
[state_space]
spacing = 0.006
box = [[{-radius}, {-radius}, {-radius}], [{radius}, {radius}, {radius}]]
""")
    return path, radius


def run(*command, timeout=None):
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=timeout).stdout
    except subprocess.TimeoutExpired:
        return ""


def forces(path):
    with open(path) as rows:
        return [[float(r[k]) for k in ("fx", "fy", "fz")] for r in csv.DictReader(rows)]


def p95(errors):
    return sorted(errors)[min(len(errors) - 1, int(0.95 * len(errors)))]


def draw(file, curves):
    """curves: body -> kind -> [(states, p95 in %)]."""
    blocks, panels = [], []
    for b, (body, kinds) in enumerate(curves.items()):
        parts = []
        for k, (kind, points) in enumerate(kinds.items()):
            blocks.append(f"$b{b}k{k} << EOD\n" + "".join(f"{n} {p}\n" for n, p in points) + "EOD\n")
            parts.append(f"$b{b}k{k} using 1:2 with linespoints pt 7 ps 0.4 lw 2 lc rgb '{INKS[k]}' title '{kind}'")
        panels.append(f"set title '{body}' noenhanced\nplot {', '.join(parts)}, 7 dt 2 lc rgb '#8a8a8a' notitle, "
                      "2 dt 2 lc rgb '#8a8a8a' notitle\n")
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    subprocess.run(["gnuplot"], check=True, text=True, input="".join(blocks) + f"""
set terminal svg size {400 * columns},{320 * rows} font 'sans-serif,12' background rgb 'white'
set output '{file}'
set logscale xy
set xrange [0.9:]
set yrange [0.1:200]
set key bottom left samplen 1 font ',9'
set grid
set xlabel 'states'
set ylabel 'error, p95 [%]'
set multiplot layout {rows},{columns}
""" + "".join(panels) + "unset multiplot\n")


def needed(args, folder, path, kind, points, truth, per_state):
    data, kernel = KINDS[kind]
    states, table = os.path.join(folder, "g.states"), os.path.join(folder, "g.csv")
    if os.path.exists(states):
        os.remove(states)
    run(args.forefeel, "generate", path, "--set", f"model.data={data}", "--set", f"model.kernel={kernel}", "--error",
        "0.02", "-o", states, "--quiet", timeout=args.seconds)
    run(args.forefeel, "export", states, "-o", table, "--quiet")
    lines = open(table).read().splitlines()
    least, last, curve = {}, None, []
    for n in COUNTS:
        if n > len(lines) - 1:
            break
        with open(os.path.join(folder, "n.csv"), "w") as out:
            out.write("\n".join(lines[: n + 1]) + "\n")
        result = os.path.join(folder, "r.csv")
        options = ["--data", data] if data == "jet" else ["--data", data, "--kernel", kernel]
        run(args.forefeel, "evaluate", os.path.join(folder, "n.csv"), "--points", points, "-o", result, "--spacing",
            "0.006", "--quiet", *options)
        errors = [math.dist(f, g) / max(math.hypot(*g), 0.05) for f, g in zip(forces(result), truth)]
        last = (n, 100 * statistics.median(errors), 100 * p95(errors), 100 * max(errors))
        curve.append((n, 100 * p95(errors)))
        for share in (0.07, 0.02):
            if p95(errors) <= share:
                least.setdefault(share, n)
        if 0.02 in least:
            break
    words = [f"{least[s]} ({least[s] * per_state:.0f} ms)" if s in least else "more" for s in (0.07, 0.02)]
    print(f"  {kind:<11} 7 %: {words[0]:<14} 2 %: {words[1]:<14} at {last[0]}: p50 {last[1]:.2f} p95 {last[2]:.2f} max "
          f"{last[3]:.1f} %; placed {len(lines) - 1}", flush=True)
    return curve


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("forefeel")
    parser.add_argument("meshes", nargs="*")
    parser.add_argument("--positions", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--bodies", default=",".join(BODIES))
    parser.add_argument("--picture")
    args = parser.parse_args()
    curves = {}
    for name in [b for b in args.bodies.split(",") if b] + args.meshes:
        with tempfile.TemporaryDirectory() as folder:
            path, radius = scene(folder, os.path.basename(name), name)
            source = random.Random(name)
            points = os.path.join(folder, "points.csv")
            at = []
            while len(at) < args.positions:
                x = [source.uniform(-radius, radius) for _ in range(3)]
                if math.hypot(*x) <= radius:
                    at.append(x)
            with open(points, "w") as out:
                out.write("x,y,z\n" + "".join("%.17g,%.17g,%.17g\n" % tuple(x) for x in at))
            solved = json.loads(run(args.forefeel, "solve", path, "--points", points, "--json", "--quiet", "--threads", "1"))["states"]
            good = [s for s in solved if s["converged"]]
            with open(points, "w") as out:
                out.write("x,y,z\n" + "".join("%.17g,%.17g,%.17g\n" % tuple(s["at"]) for s in good))
            per_state = 1e3 * statistics.median(s["seconds"] for s in good)
            print(f"{name}: {len(good)} positions to {1e3 * radius:g} mm, {len(solved) - len(good)} without equilibrium, "
                  f"{sum(s['multivalued'] for s in good)} multivalued; {per_state:.1f} ms a state", flush=True)
            for kind in KINDS:
                curves.setdefault(os.path.basename(name), {})[kind] = needed(args, folder, path, kind, points, [s["force"] for s in good], per_state)
    if args.picture:
        draw(args.picture, curves)


if __name__ == "__main__":
    main()
