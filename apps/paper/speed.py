"""Sustained speed of the tip against the number of workers: apps/studies/speed.toml (options: experiment.py).

Sustained is the highest speed at which 95 % of first visits are within 7 % of the tight solve. The paper says that the
speed is limited by the number of solving processes and gives no figure. Geometric means over the seeds; half an hour or
more a seed. An interrupted run resumes.
"""
import math
import re

from experiment import INKS, Experiment

BEST_OF = {  # a row of the comparison: the best of these steps of the study
    "predecessor": ["predecessor, trilinear 12 mm", "predecessor, tricubic 12 mm", "predecessor, tricubic 18 mm"],
    "predecessor, our start": ["predecessor, tricubic 12 mm + our start", "predecessor, tricubic 18 mm + our start"],
    "the paper, 6 mm": ["seed paper: r3 n=100, 6 mm"],
    "the paper, 12 mm": ["seed paper on its best lattice: r3 n=100, 12 mm"],
    "the paper, our start": ["seed paper, 6 mm + our start", "seed paper, 12 mm + our start"],
    "ours": ["+ first guess (default)"],
    "ours, motion known": ["default, motion known (clairvoyant)"],
    "ours, rest known before": ["default, rest known before the start"]}

paper = Experiment(__doc__, seeds=1, workers="2,4,16,64", travel=5.0)
seeds, workers, travel = (1, "2", 0.05) if paper.quick else (paper.args.seeds, paper.args.workers, paper.args.travel)
text = (paper.studies / "speed.toml").read_text()
for key, value in {"scene": f'"{paper.scene}"', "seeds": list(range(1, seeds + 1)), "travel": travel,
                   "workers": f"[{workers}]"}.items():
    text = re.sub(f"(?m)^{key} = .*$", f"{key} = {value}", text)
(paper.folder / "speed.toml").write_text(text)
paper.run("study", "speed.toml", "-o", "study")

speeds = {}  # of all seeds, by step and number of workers [m/s]; 0: below the lowest tried
for cell in paper.read("study/cells.csv"):
    speeds.setdefault((cell["step"], cell["workers"]), []).append(float(cell["sustained.speed"] or 0))
speeds = {key: math.exp(sum(map(math.log, v)) / len(v)) if min(v) else 0.0 for key, v in speeds.items()}
counts = workers.split(",")
best = {row: [max(speeds[step, n] for step in steps) for n in counts] for row, steps in BEST_OF.items()}
for row, values in best.items():
    for k, n in enumerate(counts):
        ours, before = best["ours"][k], best["predecessor"][k]
        text = f"{1e3 * values[k]:.3g} mm/s" if values[k] else "below 15.6 mm/s"
        text += f", ours x{ours / values[k]:.3g}" if values[k] and row != "ours" else ""
        paper.find(f"{row}, {n} workers", "", text, ours >= before if row == "ours" else None, speed=values[k])
paper.write("speed.csv", ["step", "workers", "speed"], [[*key, speed] for key, speed in speeds.items()])

blocks = {f"s{i}": [(int(n), 1e3 * v) for n, v in zip(counts, values) if v] or [(1, math.nan)]
          for i, values in enumerate(best.values())}
script = "set logscale xy\nset xlabel 'workers'\nset ylabel 'sustained speed [mm/s]'\nset xtics (2, 4, 8, 16, 32, 64)\n"
script += "set xrange [1.7:75]\nset key outside right\nplot "
script += ", ".join(f"$s{i} with linespoints lw 2 pt 7 ps 0.6 lc rgb '{INKS[i]}' title '{row}'"
                    for i, row in enumerate(best))
paper.draw("speed", "960,480", blocks, script + "\n")
paper.end()
