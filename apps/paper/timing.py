"""Time to update and to evaluate a model: section 4 of the paper (options: experiment.py).

The times are those of `forefeel-bench approx`, medians on one thread: Eq. 2 assembled and solved by Eigen's LU, as the
paper does; our fit of the same system; our update when 5 of the n states are replaced; and a force. The paper's are of
a 2.6 GHz Opteron. The bench is a target of its own: bash apps/setup.sh bench, then build forefeel_bench.
"""
import os
import sys

from experiment import INKS, Experiment

PAPER = {100: (160e3, "160 ms", 60, "60 us"), 300: (1.6e6, "1.6 s", 250, "200 to 250 us")}  # update, a force [us]
METHODS = [("r", 100), ("r3", 100), ("r", 300), ("r3", 300), ("hermite-r5", 25)]
MARKS = {"paper: update": (4, 1), "paper: a force": (6, 1), "Eq. 2 by LU": (5, 3), "our fit": (9, 0),
         "our update, 5 replaced": (13, 0), "our force": (7, 2)}  # point type and ink


def shown(us):
    return f"{1e-3 * us:.3g} ms" if us >= 1e3 else f"{us:.3g} us"


paper = Experiment(__doc__)
bench = paper.command + "-bench"
if not os.path.exists(bench):
    sys.exit(f"{bench} is missing: bash apps/setup.sh bench, then cmake --build --preset release -t forefeel_bench")
found = paper.run("approx", paper.scene, "-o", "bench", command=bench)
times = {(m["method"], m["n"]): m for m in found["methods"]}
lu = {row["n"]: row["baseline_us"] for row in found["rows"] if row["name"] == "refit r3"}
blocks, rows = {f"p{k}": [] for k in range(len(MARKS))}, []
for i, (method, n) in enumerate(METHODS):
    m = times[method, n]
    update, update_text, force, force_text = PAPER.get(n, (None, "", None, ""))
    system = lu[n] if method == "r3" else None
    us = [update, force, system, m["refit_us"], m["update_us"]["k5"], m["evaluate_us"]]
    paper.find(f"{method}, {n} states: update of the coefficients", update_text,
               (f"{shown(system)} by LU, " if system else "") + f"our fit {shown(us[3])}, update {shown(us[4])}",
               us[4] < update if update else None, us=us)
    paper.find(f"{method}, {n} states: a force", force_text, f"{shown(us[5])}; error p95 {m['error']['p95']:.2g}",
               us[5] < force if force else None, us=us[5], error=m["error"])
    rows.append([method, n, *us])
    for k, value in enumerate(us):
        blocks[f"p{k}"] += [(i, value)] if value else []
paper.write("timing.csv", ["method", "n", "paper_update_us", "paper_force_us", "lu_us", "refit_us", "update_us",
                           "force_us"], rows)

script = "set logscale y\nset yrange [0.01:1e7]\nset format y '10^{%T}'\nset ylabel 'time [us]'\n"
script += "set xrange [-0.5:4.5]\n"
script += "set xtics (" + ", ".join(f"'{method}, {n}' {i}" for i, (method, n) in enumerate(METHODS)) + ")\n"
script += "set key outside right\nplot 1000 dt 2 lc rgb '#8a8a8a' title 'a frame'"
for k, (title, (point, ink)) in enumerate(MARKS.items()):
    script += f", $p{k} with points pt {point} ps 1.2 lw 2 lc rgb '{INKS[ink]}' title '{title}'"
paper.draw("timing", "960,400", blocks, script + "\n")
paper.end()
