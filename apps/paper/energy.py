"""Energy around closed loops, which the paper does not study (options: experiment.py).

An elastic body returns the energy put into it; a force field that gains energy around a loop can drive a hand. Printed:
net over gross energy, |sum f . dx| / sum |f . dx|, of twelve ellipses. Fixed: the model of one set of states, the
nearest to the middle of the loop. Moving: each point has the model of its own nearest states, as a session without the
damped switch. The paper's predecessors know all states.
"""
import math

from experiment import H, INKS, Experiment, apart, model, quantile

POINTS = 400                              # of a loop
FIXED, MOVING = 1.2 * H, 2.5 * H          # half axes of the loops [m]
LOW, HIGH = (-0.036, -0.036, -0.036), (0.036, 0.036, 0.024)
MIDDLES = [(0.005335, -0.003549, -0.015699), (0.015885, 0.007045, -0.013321), (0.005873, 0.012308, 0.003221),
           (0.015649, -0.013591, 0.005132)]  # drawn at random [m]
KINDS = {"r, 100": model("linear", "force", 100), "r3, 100": model("cubic", "force", 100),
         "r5, 100": model("quintic", "force", 100), "Hermite r3, 25": model("cubic", "force+stiffness", 25),
         "Hermite r5, 25": model("quintic", "force+stiffness", 25)}
OLDER = ["trilinear", "tricubic", "deflection", "two-force", "offline-rbf", "rbf-network"]
PLANES = [((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)),
          ((2 ** -0.5, 2 ** -0.5, 0), (3 ** -0.5, -(3 ** -0.5), 3 ** -0.5))]

paper = Experiment(__doc__)
header, states = paper.lattice(LOW, HIGH)


def loops(size):
    turns = [(math.cos(t), 0.8 * math.sin(t)) for t in (2 * math.pi * i / POINTS for i in range(POINTS))]
    return [[[m + size * (p * a + q * b) for m, a, b in zip(middle, *plane)] for p, q in turns]
            for middle in MIDDLES for plane in PLANES]


def ratios(table, loops, options):
    forces = paper.forces(table, [x for loop in loops for x in loop], options)
    found = []
    for i, loop in enumerate(loops):
        force = forces[i * POINTS:(i + 1) * POINTS]
        work = [sum(0.5 * (f + g) * (b - a) for f, g, a, b in zip(*ends))  # the force of a step: mean of its ends
                for ends in zip(force, force[1:] + force[:1], loop, loop[1:] + loop[:1])]
        found.append(abs(sum(work)) / sum(map(abs, work)))
    return found


found = {}
for kind, options in KINDS.items():
    found[kind, "fixed"] = []
    for i, loop in enumerate(loops(FIXED)):
        near = sorted(states, key=lambda state: apart(state[0], MIDDLES[i // len(PLANES)]))
        paper.write("set.csv", header, [row for _, row in near[:int(kind.split()[-1])]])
        found[kind, "fixed"] += ratios("set.csv", [loop], options)
    found[kind, "moving"] = ratios("complete.csv", loops(MOVING), options)
for method in OLDER:
    found[method, "all states"] = ratios("complete.csv", loops(MOVING), ["--method", method, "--spacing", H])
for (kind, of), values in found.items():
    median, most = quantile(values, 0.5), max(values)
    paper.find(f"{kind}, {of}: net over gross energy", "", f"median {median:.1e}, at most {most:.1e}",
               median=median, max=most)
paper.write("energy.csv", ["method", "states", "loop", "net_over_gross"],
            [[*key, i, value] for key, values in found.items() for i, value in enumerate(values)])

names = list(dict.fromkeys(kind for kind, _ in found))
blocks = {"fixed": [], "moving": [], "all": []}
for (kind, of), values in found.items():
    y = len(names) - names.index(kind)
    blocks[of.split()[0]].append((quantile(values, 0.5), y - 0.2 * (of == "moving"), min(values), max(values)))
script = "set logscale x\nset format x '10^{%T}'\nset xlabel 'net over gross energy: median, least and most'\n"
script += f"set key outside top horizontal\nset yrange [0.4:{len(names) + 0.6}]\n"
tics = [f"'{name}' {len(names) - i}" for i, name in enumerate(names)]
script += "set ytics (" + ", ".join(tics) + ") noenhanced\nplot "
script += ", ".join(f"${of} using 1:2:3:4 with xerrorbars pt 7 lw 2 lc rgb '{INKS[k]}' title '{of}'"
                    for k, of in enumerate(blocks))
paper.draw("energy", f"960,{90 + 36 * len(names)}", blocks, script + "\n")
paper.end()
