"""Out of the known space: Figs. 1 and 2 of the paper (options: experiment.py).

The tip moves 6 cm into the body. All states up to its start are known; beyond it none (blank), none up to a far side
(gap), or fewer and fewer (sparse). Force and error along the path, for the paper's kernels with the 100 nearest states
and for ours (r5 on force and stiffness, 25 states by label). A jump is the change of the force from one point to the
next, 0.1 mm on, beyond its changes around them: there the set of states has changed. No switch hides it.
apps/examples/fig2.py shows higher errors; it knows 3 spacings around the path, not 5, and compares with the model of all
states, not with tight solves.
"""
import statistics

from experiment import H, INKS, JND, Experiment, apart, error, index, model, norm, percent, quantile

DEPTH, GAP, SLAB, SIDE = 10, 8, 5, 5  # of path, gap and known slab, and to each side [cells]
METHODS = {"r": model("linear", "force", 100, spacing=1000),   # states "1 km apart": the sum at any distance from them,
           "r3": model("cubic", "force", 100, spacing=1000),   # as in the paper
           "ours": model("quintic", "force+stiffness", 25, "label")}


def lot(*numbers):
    """In [0, 1), of a position of the lattice: as `classify setup:sparse` draws its states."""
    x = sum(n * f for n, f in zip(numbers, (0x9e3779b97f4a7c15, 0xbf58476d1ce4e5b9, 0x94d049bb133111eb))) % 2 ** 64
    x = (x ^ x >> 31) * 0xd6e8feb86659fd93 % 2 ** 64
    return ((x ^ x >> 32) >> 11) / 2 ** 53


def jumps(forces):
    """Of each point, in just noticeable differences."""
    steps = [[b - a for a, b in zip(*pair)] for pair in zip(forces, forces[1:])]
    sizes = [0.0]
    for i, step in enumerate(steps):
        around = zip(*steps[max(0, i - 2):i + 3])
        sizes.append(apart(step, [statistics.median(c) for c in around]) / max(JND * norm(forces[i + 1]), 0.01))
    return sizes


def crossing(known, path):
    """Points where the 100 nearest states first hold one of the far side, and first none of the near side."""
    enters = leaves = None
    for i, x in enumerate(path):
        far = sum(-at[2] > 0.5 * GAP * H for at in sorted(known, key=lambda at: apart(at, x))[:100])
        enters = i if enters is None and far else enters
        leaves = i if leaves is None and far == 100 else leaves
    return enters, leaves


paper = Experiment(__doc__)
for name in ["sparse", "gap", "blank"]:
    paper.run("classify", "setup:" + name, "-o", f"situation-{name}.svg", scene=False)  # Fig. 1
header, states = paper.lattice((-SIDE * H, -SIDE * H, -DEPTH * H), (SIDE * H, SIDE * H, SLAB * H))
known = {"blank": [], "gap": [], "sparse": []}
for at, row in sorted(states, key=lambda state: (state[0][1], state[0][0], -state[0][2])):  # as `setup:` lists them
    x, y, z = index(at)
    layer, drawn = -z, lot(-z, x, y)  # layer 0: the start
    for name, kept in [("blank", False), ("gap", layer >= GAP), ("sparse", drawn < 0.5 * (1 - layer / (DEPTH + 1)))]:
        known[name] += [(at, row)] if layer <= 0 or kept else []
for name, some in known.items():
    paper.write(name + ".csv", header, [row for _, row in some])

steps = 120 if paper.quick else 600
path = [(0.0, 0.0, -DEPTH * H * i / steps) for i in range(steps + 1)]
paper.write("stations.csv", ["x", "y", "z"], path[::steps // 30])
solved = paper.run("solve", paper.scene, "--points", "stations.csv")["states"]
tight = {i * (steps // 30): state["force"] for i, state in enumerate(solved) if state["converged"]}
enters, leaves = crossing([at for at, _ in known["gap"]], path)
blocks = {"tight": [(-1e3 * path[i][2], norm(force)) for i, force in tight.items()]}
rows, blank = [], {}
for m, (method, options) in enumerate(METHODS.items()):
    complete = paper.forces("complete.csv", path, options)
    for name in known:
        forces = paper.forces(name + ".csv", path, options)
        jump = jumps(forces)
        beside = [error(f, c) for f, c in zip(forces, complete)]
        off = {i: error(forces[i], force) for i, force in tight.items()}
        rows += [[name, method, -x[2], *f, j, e, off.get(i, "")]
                 for i, (x, f, j, e) in enumerate(zip(path, forces, jump, beside))]
        blocks[f"{name}{m}"] = [(-1e3 * x[2], norm(f), max(100 * e, 1e-5)) for x, f, e in zip(path, forces, beside)]

        says, holds = "", None
        worst = [max(e for i, e in off.items() if i <= steps * k / 3) for k in (1, 2, 3)]  # to each third of the path
        if name == "blank":
            blank[method] = worst[2]
            says, holds = "grows rapidly", worst[0] < worst[1] < worst[2]
        if name == "sparse":
            says, holds = "relatively low", worst[2] < blank[method] / 4
        paper.find(f"{name}, {method}: error p50, p95, max", says,
                   ", ".join(percent(quantile(off.values(), q)) for q in (0.5, 0.95, 1)), holds, error=worst)
        if name == "gap" and method == "ours":
            most = max(range(steps * GAP // DEPTH), key=lambda i: jump[i])
            paper.find("gap, ours: largest jump", "", f"{jump[most]:.2g} JND at {-1e3 * path[most][2]:.1f} mm",
                       jump[most] <= 1, jnd=jump[most])
        elif name == "gap":
            at = [max(range(i - 1, i + 2), key=lambda k: jump[k]) for i in (enters, leaves)]
            both = [jump[i] for i in at]
            shown = [f"{jump[i]:.2g} JND at {-1e3 * path[i][2]:.1f} mm" for i in at]
            paper.find(f"gap, {method}: far side enters, near side leaves", "two rapid changes", ", ".join(shown),
                       max(both) > 1, jnd=both)
paper.write("extrapolation.csv", ["situation", "method", "s", "fx", "fy", "fz", "jump_jnd", "error_complete",
                                  "error_tight"], rows)

script = f"set multiplot layout 3,2\nset xrange [0:{1e3 * DEPTH * H}]\nset xlabel 'displacement [mm]'\n"
for name in known:
    curve = [f"${name}{m} using 1:%d with lines lw 2 lc rgb '{INKS[m]}' title '{method}'"
             for m, method in enumerate(METHODS)]
    script += f"set title '{name}'\nset ylabel 'force [N]'\nunset logscale\nset yrange [0:*]\nset key top left\n"
    script += "plot $tight with points pt 6 lc rgb '#1b1b1b' title 'tight solves', " + ", ".join(c % 2 for c in curve)
    script += "\nset ylabel 'error [%]'\nset logscale y\nset yrange [1e-4:1000]\nunset key\n"
    script += "plot 7 dt 2 lc rgb '#8a8a8a', " + ", ".join(c % 3 for c in curve) + "\n"
paper.draw("extrapolation", "960,940", blocks, script)
paper.end()
