"""Predictors of a finished study as CSV: calibration.py FOLDER. Means over motions, with Student's intervals of 95 %.

p95_mm: error of the predicted place; within_50, within_90 [%]: true places in the balls that should hold so many.
"""
import csv
import sys

import numpy as np
import pandas as pd
from scipy import stats

try:
    cells = pd.read_csv(sys.argv[1] + "/cells.csv")
    cells["session.predictor"]
except (IndexError, OSError, KeyError) as error:
    print(f"calibration.py: expected the folder of a finished study that varies session.predictor ({error!r})",
          file=sys.stderr)
    sys.exit(2)
out = csv.writer(sys.stdout)
out.writerow(["predictor", "horizon_ms"] + [name + end for name in ("p95_mm", "within_50", "within_90")
                                            for end in ("", "_low", "_high")])
for predictor, rows in cells.groupby("session.predictor"):
    for horizon in 20, 50, 100, 200, 500:
        columns = [f"prediction.ms{horizon}.{name}" for name in ("p95", "within_50", "within_90")]
        motions = rows.groupby(["device", "seed"])[columns].mean() * [1e3, 100, 100]
        half = stats.t.ppf(0.975, len(motions) - 1) * motions.std() / np.sqrt(len(motions))
        out.writerow([predictor, horizon] + [f"{v:.3g}" for mean, h in zip(motions.mean(), half)
                                             for v in (mean, mean - h, mean + h)])
