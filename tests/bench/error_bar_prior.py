"""Scores of error bars of sessions: the prior of grasp_prior() in approx/error/error_bar.cpp, and how well bars cover.

    /usr/bin/python3 tests/bench/error_bar_prior.py prior FOLDER...    # prints its rows
    /usr/bin/python3 tests/bench/error_bar_prior.py check|check-anywhere SEED [COUNT] [SECONDS] [FOLDER]

check: COUNT (10) sessions of SECONDS (10), each of a body, a law, a contact and a motion drawn at random from the seed:
how well bars cover, in the worst 2 s of a session, above and at the floor of the bars, and what they decide at the just
noticeable difference (JND). Runs build/release/apps/forefeel under the virtual clock. FOLDER keeps the runs.
check-anywhere: the same of sessions with contact.anywhere, whose prior is in scheduling/judge/surface_judge.cpp.
prior: of such runs, the scores sqrt(max(0, e^2 - r^2)) / s of samples whose bar of 95 % is above its floor: e is the
distance of the rendered force from that of a tight solve, r what the switch holds back, s the scale in frames.csv.
"""
import csv
import math
import pathlib
import random
import subprocess
import sys
import tempfile

SHARES = [0.05, 0.25, 0.5, 0.7, 0.8, 0.85, 0.9, 0.925, 0.95, 0.96, 0.97, 0.975, 0.98, 0.985, 0.99, 1.0]
LABELS = ["safe", "sparse", "gap", "blank"]
LEVELS = {"bar90": 0.90, "bar95": 0.95, "bar99": 0.99}


def samples(keys, options, seconds, folder):
    command = ["build/release/apps/forefeel", "session", "apps/scenes/liver.toml", "--clock", "virtual", "--quiet",
               "--threads", "1", "--seconds", str(seconds), "-o", str(folder), *options]
    for key in keys:
        command += ["--set", key]
    if not (folder / "frames.csv").exists():
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 1):
            print(f"{keys} {options}: {done.stderr.strip()}", file=sys.stderr)
            return []
    return judged_rows(folder)


def judged_rows(folder):
    with open(folder / "frames.csv") as file:
        return [row for row in csv.DictReader(file) if row["sampled"] == "1" and row["error"]]


def drawn_session(draw):
    """Keys of the scene and options of the command of a session drawn at random."""
    law = draw.choice(["linear", "st-venant-kirchhoff", "neo-hookean", "stable-neo-hookean", "mooney-rivlin"])
    phantom = draw.choice(["liver", "beam", "ball", "slab"])
    keys = [f"body.phantom={phantom}", f"material.law={law}", f"material.poisson={draw.uniform(0.0, 0.48):.3f}",
            f"material.young={10**draw.uniform(3.3, 4.5):.0f}", f"session.seed={draw.randrange(10**6)}",
            f"body.elements={draw.randint(300, 900)}"]
    if draw.random() < 0.25:
        keys.append("contact={nearest=[0.0,0.0,1.0]}")
    path = draw.choice(["press", "line", "circle", "lissajous", "reach", "palpation", "tour", "mower", "raster"])
    device = f"path:{path},speed={draw.uniform(0.02, 0.09):.3f}"
    if draw.random() < 0.3:
        device += f",tremor={draw.uniform(5e-5, 4e-4):.6f}"
    cost = draw.choice(["paper", "constant:0.05", "lognormal:0.2,0.5", "lognormal:0.05,0.8"])
    return keys, ["--device", device, "--cost", cost, "--set", f"session.workers={draw.randint(2, 6)}"]


def drawn_touch(draw):
    """The same of a session with contact.anywhere."""
    law = draw.choice(["neo-hookean", "mooney-rivlin", "st-venant-kirchhoff", "stable-neo-hookean", "linear"])
    phantom, depth = draw.choice(["liver", "beam", "slab", "ball"]), draw.uniform(0.005, 0.016)
    contact = (f"contact={{anywhere=true,pad={draw.choice([400, 1000, 3000])},"
               f"radius={draw.choice([0.01, 0.015, 0.02])},friction={draw.choice([0.1, 0.3, 0.6])}}}")
    keys = [f"body.phantom={phantom}", f"material.law={law}", f"material.poisson={draw.choice([0.3, 0.4, 0.45])}",
            f"material.young={draw.choice([2000, 5000, 20000])}", f"body.elements={draw.choice([600, 1000, 1600])}",
            "body.fine=false", contact, f"state_space={{depth={depth:.4f}}}", "session.discretisation_error=false"]
    path = draw.choice(["line", "raster", "palpation", "tour"])
    speed = "" if path == "palpation" else f",speed={draw.uniform(0.02, 0.1):.3f}"
    policy = draw.choice(["error", "coverage", "nearest"])
    return keys, ["--device", f"path:{path},depth={0.9 * depth:.4f}{speed}", "--policy", policy, "--workers",
                  str(draw.choice([1, 2, 4])), "--cost", draw.choice(["paper", "constant:0.02"])]


def vector(row, name):
    """The three columns name_x or namex, ..."""
    return [float(row[name + axis]) for axis in "xyz"]


def score(row):
    """Score of a frame; None where it has no bar."""
    if not row["bar_scale"]:
        return None
    force, plain, truth = vector(row, "rendered_"), vector(row, "u"), vector(row, "r")
    error2 = sum((a - b) ** 2 for a, b in zip(force, truth))
    held2 = sum((a - b) ** 2 for a, b in zip(force, plain))
    return math.sqrt(max(0.0, error2 - held2)) / float(row["bar_scale"])


JND = lambda force: max(0.07 * math.hypot(*force), 0.01)  # [N], the defaults of session.jnd


class Sample:
    """A sampled frame with a bar: its error, bars, label and decision at the JND [N]."""

    def __init__(self, row):
        force, truth = vector(row, "rendered_"), vector(row, "r")
        self.t, self.label, self.error = float(row["t"]), row["label"], math.dist(force, truth)
        self.bars = [float(row[bar]) for bar in LEVELS]
        self.floored = [bar <= JND(force) / 10 * (1 + 1e-9) for bar in self.bars]
        self.said, self.good = self.bars[1] <= JND(force), self.error <= JND(truth)


def held(samples, level):
    return sum(s.error <= s.bars[level] for s in samples) / len(samples) if samples else math.nan


def worst_window(samples, seconds=2.0, least=20):
    """Least coverage of the 95 % bars in any `seconds` with at least so many samples, and its begin."""
    worst, first, inside = (math.nan, math.nan), 0, [s.error <= s.bars[1] for s in samples]
    for last in range(len(samples)):
        while samples[last].t - samples[first].t > seconds:
            first += 1
        share = sum(inside[first:last + 1]) / (last + 1 - first)
        if last + 1 - first >= least and samples[last].t >= seconds and not worst[0] <= share:
            worst = (share, samples[first].t)
    return worst


def print_check(drawn, seed, count, seconds, folder):
    draw, every = random.Random(seed), []
    for k in range(count):
        keys, options = drawn(draw)
        rows = samples(keys, options, seconds, folder / f"{seed}-{k}")
        mine = [Sample(row) for row in rows if row["bar95"]]
        if not mine:
            print(f"{k}: no samples ({len(rows)} rows)")
            continue
        every.append(mine)
        share, begin = worst_window(mine)
        print(f"{k}: {len(mine)} samples, without a bar {len(rows) - len(mine)}, inside 90/95/99 %: "
              + " ".join(f"{100 * held(mine, level):.1f}" for level in range(3))
              + f", worst 2 s {100 * share:.0f} % at {begin:.1f} s  " + " ".join(keys + options), flush=True)
    pooled = [s for mine in every for s in mine]
    print(f"{len(every)} sessions, {len(pooled)} samples, inside 90/95/99 %: "
          + " ".join(f"{100 * held(pooled, level):.1f}" for level in range(3)))
    for level, name in enumerate(LEVELS):
        above = [s for s in pooled if not s.floored[level]]
        print(f"{name}: {len(pooled) - len(above)} samples at the floor, {len(above)} above it, of these inside "
              f"{100 * held(above, level):.1f} %")
    print("worst 2 s: " + " ".join(f"{100 * worst_window(mine)[0]:.0f}" for mine in every) + " %")
    for label in LABELS:
        own = [s for s in pooled if s.label == label]
        print(f"{label}: {len(own)} samples, inside " + " ".join(f"{100 * held(own, level):.1f}" for level in range(3)))
    said, bad = [s for s in pooled if s.said], [s for s in pooled if not s.good]
    share = lambda of, among: 100 * sum(map(of, among)) / len(among) if among else math.nan
    print(f"at the JND: bar below it in {len(said)} ({share(lambda s: s.said, pooled):.1f} %), of these "
          f"{share(lambda s: not s.good, said):.2f} % "
          f"erred by more; {len(bad)} erred by more, of these flagged {share(lambda s: not s.said, bad):.1f} %; "
          f"within it {share(lambda s: s.good, pooled):.1f} %")


def print_prior(folders):
    scores = {label: [] for label in LABELS}
    for folder in folders:
        for row in judged_rows(pathlib.Path(folder)):
            if row["bar95"] and not Sample(row).floored[1]:
                scores[row["label"]].append(score(row))
    for label, own in scores.items():
        own.sort()
        print(f"// {label}: {len(own)} scores")
        if own:
            ranks = [own[max(0, math.ceil(share * len(own)) - 1)] for share in SHARES]
            print("{{" + ", ".join(f"{rank:.3g}" for rank in ranks) + "}},")


def main():
    kind, given = (sys.argv[1] if len(sys.argv) > 1 else ""), sys.argv[2:]
    if kind == "prior" and given:
        print_prior(given)
    elif kind in ("check", "check-anywhere") and given:
        with tempfile.TemporaryDirectory() as folder:
            seed, count, seconds, kept = given + [None, "10", "10", folder][len(given):]
            print_check(drawn_session if kind == "check" else drawn_touch, int(seed), int(count), float(seconds), pathlib.Path(kept))
    else:
        sys.exit("error_bar_prior.py: expected prior FOLDER..., check SEED or check-anywhere SEED")


if __name__ == "__main__":
    main()
