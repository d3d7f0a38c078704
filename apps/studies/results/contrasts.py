"""Contrasts of a finished study as CSV: contrasts.py FOLDER [--than nearest] [--pairs A:B ...] [--at COLUMN ...].

Each policy against --than, over all cells and at each level of the columns --at; then the pairs of policies, and each
policy's predictors against constant-velocity. points: difference of first visits within the JND; factor: of the p95
error of first visits. A motion (device and seed) is one sample: means over its cells, paired; intervals are Student's of
95 %; p_holm is Holm's over the rows of a block (measure, at), for points.
"""
import argparse
import csv
import sys

import numpy as np
import pandas as pd
from scipy import stats

parser = argparse.ArgumentParser()
parser.add_argument("folder")
parser.add_argument("--than", default="nearest")
for flag in "--pairs", "--at":
    parser.add_argument(flag, nargs="*", default=[])
args = parser.parse_args()
try:
    cells = pd.read_csv(args.folder + "/cells.csv")
except OSError as error:
    parser.error(f"{args.folder}: {error.strerror}, expected the folder of a finished study")
pairs = [pair.split(":") for pair in args.pairs]
for name in [args.than, *(name for pair in pairs for name in pair)]:
    if name not in set(cells.policy):
        parser.error(f"policy '{name}' is not in the study, expected one of {', '.join(sorted(set(cells.policy)))}")
for pair in pairs:
    if len(pair) != 2:
        parser.error(f"--pairs {':'.join(pair)}: expected A:B")
for column in args.at:
    if column not in cells:
        parser.error(f"--at {column}: no such column of cells.csv")
cells["jnd"] = 100 * cells["error.first_visit.within_jnd"]
cells["log"] = np.log(cells["error.first_visit.p95"].clip(lower=1e-4))
out = csv.writer(sys.stdout)
out.writerow("at,policy,than,jnd_percent,points,low,high,p_holm,factor,factor_low,factor_high,motions".split(","))


def means(rows):
    return rows.groupby(["device", "seed"])[["jnd", "log"]].mean()


def block(at, named):
    """named: (name, than, rows, rows of than)"""
    found = []
    for name, than, these, those in named:
        pairs = (means(these) - means(those)).dropna()
        half = stats.t.ppf(0.975, len(pairs) - 1) * pairs.std() / np.sqrt(len(pairs))
        found.append((name, than, these.jnd.mean(), pairs.mean(), half, len(pairs),
                      stats.ttest_1samp(pairs.jnd, 0).pvalue if pairs.jnd.std() > 0 else 1.0))
    order, least = np.argsort([row[-1] for row in found]), 0.0
    holm = np.ones(len(found))
    for rank, k in enumerate(order):
        holm[k] = least = min(1.0, max(least, (len(found) - rank) * found[k][-1]))
    for (name, than, level, mean, half, n, _), p in zip(found, holm):
        points = [f"{v:.2f}" for v in (mean.jnd, mean.jnd - half.jnd, mean.jnd + half.jnd)]
        factor = [f"{np.exp(v):.3f}" for v in (mean.log, mean.log - half.log, mean.log + half.log)]
        out.writerow([at, name, than, f"{level:.1f}", *points, f"{p:.2g}", *factor, n])


def of(rows, policy):
    return rows[rows.policy == policy]


others = [policy for policy in cells.policy.unique() if policy != args.than]
block("all", [(args.than, "", of(cells, args.than), of(cells, args.than))])
block("all", [(policy, args.than, of(cells, policy), of(cells, args.than)) for policy in others])
block("all", [(a, b, of(cells, a), of(cells, b)) for a, b in pairs])
for column in args.at:
    for level, rows in cells.groupby(column):
        block(f"{column} = {level}", [(policy, args.than, of(rows, policy), of(rows, args.than)) for policy in others])
        block(f"{column} = {level}", [(a, b, of(rows, a), of(rows, b)) for a, b in pairs])
if "session.predictor" in cells:
    predictors = dict(list(cells.groupby("session.predictor")))
    for policy in cells.policy.unique():
        rows = [(name, of(these, policy)) for name, these in predictors.items() if name != "constant-velocity"]
        block(f"policy = {policy}", [(name, "constant-velocity", these, of(predictors["constant-velocity"], policy))
                                     for name, these in rows])
