"""States needed for an error, by sampler, body and model: needed.py STUDY.toml [--part K/N] -o FOLDER; then --merge.

Each script of this folder that the study names runs on each body; its table is a file of FOLDER, kept when the run is
repeated. --merge reads them all. States needed: where the line through (log n, log p95) crosses the error, after which
it stays below; "> n", "<= n" beyond the last and the first n. Then the error and the seconds (CPU) of planning and of
solving, of the last n. Medians over seeds. Ratios to Halton's points on the same body and model, if both are known; the
interval is a 95 % bootstrap over bodies, none below four.
"""
import argparse
import csv
import itertools
import pathlib
import subprocess
import sys
import tomllib

import numpy as np

parser = argparse.ArgumentParser()
parser.add_argument("study", type=pathlib.Path)
parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
parser.add_argument("--part", default="1/1", metavar="K/N")
parser.add_argument("--merge", action="store_true")
args = parser.parse_args()
try:
    part, parts = map(int, args.part.split("/"))
    study = tomllib.loads(args.study.read_text())
    missing = [key for key in ("states", "errors", "seeds", "samplers", "body") if key not in study]
except (OSError, ValueError) as error:
    parser.error(f"{args.study}, --part {args.part}: {error}")
if missing:
    parser.error(f"{args.study}: no key '{missing[0]}'")
if not 1 <= part <= parts:
    parser.error(f"--part {args.part}: expected 1/{parts} to {parts}/{parts}")
for sampler in study["samplers"]:
    if not pathlib.Path(__file__).with_name(sampler + ".py").exists():
        parser.error(f"{args.study}: sampler '{sampler}' has no script beside needed.py")
args.output.mkdir(parents=True, exist_ok=True)
tables = {(body["name"], sampler): args.output / f"{body['name']}, {sampler}.csv".replace(" ", "_")
          for sampler in study["samplers"] for body in study["body"]}


def run(body, sampler, table):
    command = [sys.executable, str(pathlib.Path(__file__).with_name(sampler + ".py")),
               str(args.study.parent / body["scene"]), "--seeds", str(study["seeds"]), "--states",
               *map(str, study["states"])]
    command += [word for key in body["set"] for word in ("--set", key)] + (["--alone"] if sampler != "common" else [])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 0:
        part = table.with_suffix(".part")
        part.write_text(done.stdout)
        part.rename(table)
    print(f"{body['name']}, {sampler}: {'done' if done.returncode == 0 else done.stderr.strip()}", flush=True)
    return done.returncode == 0


def needed(rows, wanted):
    """rows: {n: row}. Infinite if it is not between two n."""
    n, p95 = np.array([(n, row["p95_percent"]) for n, row in sorted(rows.items())]).T
    above = np.flatnonzero(p95 > wanted)
    if len(above) == 0 or above[-1] == len(n) - 1:
        return np.inf if len(above) else -np.inf
    k = above[-1]
    share = np.log(p95[k] / wanted) / np.log(p95[k] / p95[k + 1])
    return n[k] * (n[k + 1] / n[k]) ** share


if not args.merge:
    failed = False
    for job, ((name, sampler), table) in enumerate(tables.items()):
        if job % parts == part - 1 and not table.exists():
            failed |= not run(next(body for body in study["body"] if body["name"] == name), sampler, table)
    sys.exit(1 if failed else 0)

first, last = min(study["states"]), max(study["states"])
quantities = {f"states for {wanted} %": lambda rows, wanted=wanted: needed(rows, wanted) for wanted in study["errors"]}
columns = "p95_percent", "planning_s", "solving_s"
quantities |= {f"{column} of {last}": lambda rows, column=column: rows[last][column] for column in columns}
found, out, bodies = {}, csv.writer(sys.stdout), [body["name"] for body in study["body"]]
for (body, _), table in tables.items():
    for row in csv.DictReader(table.open()) if table.exists() else []:
        of_n = found.setdefault((row["sampler"], row["model"], body), {}).setdefault(int(row["states"]), [])
        of_n.append([float(row[column]) for column in columns])    # of each seed
found = {key: {n: dict(zip(columns, np.median(seeds, axis=0))) for n, seeds in rows.items()}
         for key, rows in found.items()}
out.writerow(["quantity", "sampler", "model", *bodies, "over_halton", "low", "high"])
names = dict.fromkeys(key[:2] for key in found)
for (what, quantity), (sampler, model) in itertools.product(quantities.items(), names):
    here, halton = (np.array([quantity(found[key]) if (key := (name, model, body)) in found else np.nan
                              for body in bodies]) for name in (sampler, "halton"))
    known = np.isfinite(here) & np.isfinite(halton)    # a model "own" has no row of Halton's points
    logs = np.log(here[known] / halton[known])
    drawn = np.random.default_rng(1).choice(logs, (2000, len(logs))).mean(axis=1) if len(logs) > 3 else [np.nan]
    words = [{np.inf: f"> {last}", -np.inf: f"<= {first}"}.get(v, "" if np.isnan(v) else f"{v:.3g}") for v in here]
    ratios = np.exp([np.mean(logs) if len(logs) else np.nan, *np.percentile(drawn, [2.5, 97.5])])
    out.writerow([what, sampler, model, *words, *("" if np.isnan(r) else f"{r:.2f}" for r in ratios)])
