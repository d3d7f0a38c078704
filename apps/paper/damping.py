"""States that arrive while the hand rests: Fig. 3 of the paper (options: experiment.py).

The tip moves out of the known space and is held there. Then groups of states become known, the most distant first,
until the space is full. Sessions under the virtual clock with these arrivals, without and with damping, with the
paper's settings (r3, 100 nearest states) and with ours.
"""
from experiment import H, INKS, JND, Experiment, apart, error, norm, percent

DEPTH, SLAB, SIDE, GROUPS = 10, 5, 5, 8
HELD = 7.75 * H                         # not a position of the lattice [m]
OURS = {"state_space.spacing": H}
PAPERS = {"model.kernel": "cubic", "model.data": "force", "model.neighbours": 100, "session.select": "nearest",
          "state_space.spacing": 10, "session.update_travel": 0.25 * H / 10}  # "10 m apart": the sum at any distance
WAYS = [("the paper's, undamped", PAPERS, "none", "exceeds the JND by far"),
        ("the paper's, damped", PAPERS, "paper", "within the JND of 7 %"),
        ("ours, undamped", OURS, "none", ""), ("ours, smooth", OURS, "smooth", "")]

paper = Experiment(__doc__, interval=10.0)
interval = 0.4 if paper.quick else paper.args.interval  # between groups [s]
first = max(interval, HELD / 0.05 + 0.5)                # the tip has come, at 5 cm/s [s]
seconds = first + GROUPS * interval
low, high, tip = (-SIDE * H, -SIDE * H, -DEPTH * H), (SIDE * H, SIDE * H, SLAB * H), (0.0, 0.0, -HELD)
header, states = paper.lattice(low, high)
paper.write("known.csv", header, [row for at, row in states if at[2] > -H / 2])
rest = sorted((at for at, _ in states if at[2] < -H / 2), key=lambda at: -round(apart(at, tip), 9))
paper.write("arrivals.csv", ["t", "x", "y", "z"],
            [(first + interval * (i * GROUPS // len(rest)), *at) for i, at in enumerate(rest)])
paper.write("motion.csv", ["t", "x", "y", "z"],
            [(HELD / 0.05 * u, 0, 0, -HELD * u * u * (3 - 2 * u)) for u in (i / 20 for i in range(21))])
truth = paper.run("solve", paper.scene, "--at=" + ",".join(map(str, tip)))["states"][0]["force"]

blocks = {"tight": [(0, norm(truth)), (seconds, norm(truth))]}
rows = []
for w, (way, settings, switch, says) in enumerate(WAYS):
    paper.run("session", paper.scene, "--clock", "virtual", "--seconds", seconds, "--device", "trace:motion.csv",
              "--arrivals", "arrivals.csv", "--states", "known.csv", "--switch", switch, "-o", f"run{w}",
              "--set=session.reference_step=1", f"--set=state_space.box=[{list(low)},{list(high)}]",
              *(f"--set={key}={value}" for key, value in settings.items()))
    frames = list(paper.read(f"run{w}/frames.csv"))
    t = [float(f["t"]) for f in frames]
    force = [[float(f["rendered_" + c]) for c in "xyz"] for f in frames]
    newest = [[float(f["u" + c]) for c in "xyz"] for f in frames]
    share = [0] + [apart(b, a) / max(norm(a), 0.01) for a, b in zip(force, force[1:])]
    after = [i for i in range(len(t)) if t[i] > first - 1e-9]
    jump = max(after, key=lambda i: float(frames[i]["undamped_jump"]))
    most, newton = max(share[i] for i in after), float(frames[jump]["undamped_jump"])
    over = sum(float(frames[i]["switch_change"]) > float(frames[i]["switch_bound"]) for i in after)
    paper.find(f"{way}: largest change in a frame", says, f"{percent(most)}; models differ by {newton:.3g} N",
               most > JND if switch == "none" else most <= JND and over == 0, share=most, newton=newton)
    if switch != "none":
        changing = [(t[i] - first + 1e-6) % interval for i in after if apart(force[i], newest[i]) > 1e-9]
        took = max(changing, default=0) + 0.001
        paper.find(f"{way}: settled within", "several frames" if settings is PAPERS else "", f"{1e3 * took:.0f} ms",
                   took < interval, seconds=took)
    off = [error(force[i], truth) for i in (after[0] - 1, -1)]
    paper.find(f"{way}: error before the groups, at the end", "", ", ".join(map(percent, off)), off[1] < off[0],
               error=off)
    zoom = t[jump] if w == 0 else zoom
    shown = [i for i in range(len(t)) if i % 50 == 0 or share[i] > 1e-5]
    rows += [[way, t[i], *force[i], *newest[i], share[i]] for i in shown]
    blocks[f"force{w}"] = [(t[i], norm(force[i])) for i in shown]
    blocks[f"share{w}"] = [(t[i], max(1e-4, 100 * share[i])) for i in shown]
    blocks[f"zoom{w}"] = [(1e3 * (t[i] - zoom), norm(force[i])) for i in range(len(t)) if -0.02 < t[i] - zoom < 0.15]
paper.write("damping.csv", ["method", "t", "fx", "fy", "fz", "newest_x", "newest_y", "newest_z", "change"], rows)


def curves(block):
    return ", ".join(f"${block}{w} with lines lw 2 lc rgb '{INKS[w]}' title \"{way[0]}\"" for w, way in enumerate(WAYS))


paper.draw("damping", "960,640", blocks, f"""set multiplot
set size 1,0.5
set origin 0,0.5
set xlabel 'time [s]'
set ylabel 'force [N]'
set yrange [0:*]
set key bottom right
plot $tight with lines dt 2 lc rgb '#8a8a8a' title 'tight solve', {curves("force")}
set size 0.6,0.5
set origin 0,0
unset key
set logscale y
set yrange [1e-4:1000]
set ylabel 'change from frame to frame [%]'
plot 7 dt 2 lc rgb '#8a8a8a', {curves("share")}
set size 0.4,0.5
set origin 0.6,0
unset logscale y
set yrange [*:*]
set xlabel 'time after the group at {zoom:.4g} s [ms]'
set ylabel 'force [N]'
plot {curves("zoom")}
""")
paper.end()
