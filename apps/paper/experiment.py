"""What the scripts of this folder share: the command, files, pictures, and the paper's figures beside ours.

Igor Peterlik and Jiri Filipovic, Haptic Rendering Based on RBF Approximation from Dynamically Updated Data. Each script
runs `forefeel` as a person would, writes tables (.csv), pictures (.svg, drawn by gnuplot) and summary.json into a
folder, prints the paper's figures beside ours, and ends with 1 if something does not hold. Only Python is needed.

    python3 extrapolation.py -o DIR [SCENE] [--quick] [--set KEY.PATH=VALUE] [--forefeel COMMAND]

On a SCENE other than apps/scenes/paper.toml the contact must give way 6 cm along -z. --quick: a coarse body and short
runs, to see a script work; its figures mean nothing.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

H = 0.006                # the paper's cell [m]
JND, LEAST = 0.07, 0.05  # just noticeable share of a force; least force that an error is relative to [N]
INKS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a", "#1b1b1b"]


def norm(x):
    return math.sqrt(sum(c * c for c in x))


def apart(a, b):
    return norm([p - q for p, q in zip(a, b)])


def index(at):
    """Of a position of the lattice."""
    return [round(c / H) for c in at]


def error(force, truth):
    return apart(force, truth) / max(norm(truth), LEAST)


def quantile(values, share):
    """The nearest of the values, as in the summaries of forefeel."""
    return sorted(values)[math.floor(share * (len(values) - 1) + 0.5)]


def percent(share):
    return f"{100 * share:.3g} %"


def model(kernel, data, neighbours, select="nearest", spacing=H):
    """Options of `evaluate`."""
    return ["--kernel", kernel, "--data", data, "--neighbours", neighbours, "--select", select, "--spacing", spacing]


class Experiment:
    def __init__(self, about, **options):
        here = pathlib.Path(__file__).resolve().parent
        built = here.parent.parent / "build/release/apps/forefeel"
        parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
        parser.add_argument("scene", nargs="?", default=here.parent / "scenes/paper.toml", metavar="SCENE")
        parser.add_argument("-o", "--output", required=True, type=pathlib.Path, metavar="DIR")
        parser.add_argument("--quick", action="store_true")
        parser.add_argument("--set", action="append", default=[], metavar="KEY.PATH=VALUE")
        parser.add_argument("--forefeel", default=str(built) if built.exists() else "forefeel", metavar="COMMAND")
        for name, default in options.items():
            parser.add_argument("--" + name, type=type(default), default=default, help=f"default: {default}")
        self.args = parser.parse_args()
        found = shutil.which(self.args.forefeel) or parser.error(f"--forefeel {self.args.forefeel}: no such command")
        self.command = os.path.abspath(found)
        self.scene = os.path.abspath(self.args.scene)
        self.changes = (["body.elements=300"] if self.args.quick else []) + self.args.set
        self.quick, self.folder, self.studies = self.args.quick, self.args.output, here.parent / "studies"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.rows = []

    def run(self, *words, scene=True, command=None):
        """The document that the command prints with --json. scene: it reads the scene, so --set belongs to it."""
        line = [command or self.command, *map(str, words), "--json", "--quiet"]
        line += ["--set=" + change for change in self.changes if scene]
        done = subprocess.run(line, cwd=self.folder, capture_output=True, text=True)
        codes = (0, 1) if words[0] in ("solve", "generate") else (0,)  # 1: some states have no solution
        if done.returncode not in codes or not done.stdout:
            sys.exit(f"{' '.join(line)}: exit code {done.returncode}\n{done.stderr}")
        return json.loads(done.stdout)

    def lattice(self, low, high):
        """All states of the lattice in a box, in complete.csv: its columns, and for each state its position and row."""
        self.run("generate", self.scene, "-o", "complete.states", f"--set=state_space.spacing={H}",
                 f"--set=state_space.box=[{list(low)},{list(high)}]")
        self.run("export", "complete.states", "-o", "complete.csv", scene=False)
        with open(self.folder / "complete.csv") as table:
            header, *rows = csv.reader(table)
        states = [(tuple(map(float, row[:3])), row) for row in rows]
        states.sort(key=lambda state: (sum(n * n for n in index(state[0])), index(state[0])))  # from rest outwards
        self.write("complete.csv", header, [row for _, row in states])
        return header, states

    def forces(self, states, points, options):
        """The force at each point from a table of states [N]."""
        self.write("points.csv", ["x", "y", "z"], points)
        return self.run("evaluate", states, "--points", "points.csv", "--no-bars", *options, scene=False)["forces"]

    def write(self, name, header, rows):
        with open(self.folder / name, "w", newline="") as table:
            csv.writer(table, lineterminator="\n").writerows([header, *rows])

    def read(self, name):
        """The rows of a table, each by its columns."""
        with open(self.folder / name) as table:
            yield from csv.DictReader(table)

    def draw(self, name, size, blocks, script):
        """Writes NAME.svg. blocks: rows of numbers by name, $name in the script of gnuplot."""
        if not shutil.which("gnuplot"):
            return print("gnuplot is not installed: no picture")
        text = f"set terminal svg size {size} background '#ffffff' font 'sans,12'\nset output '{name}.svg'\nset grid\n"
        for block, rows in blocks.items():
            text += f"${block} << EOD\n" + "".join(" ".join(f"{v:.9g}" for v in row) + "\n" for row in rows) + "EOD\n"
        subprocess.run(["gnuplot"], input=text + script, text=True, check=True, cwd=self.folder)

    def find(self, what, paper, ours, holds=None, **values):
        """A line of the comparison. holds: whether ours is as the paper says, or as it must be; None: no claim."""
        self.rows.append({"what": what, "paper": paper, "ours": ours, "holds": holds, **values})

    def end(self):
        print(f"{'':<52} {'the paper':<24} here")
        for row in self.rows:
            print(f"{row['what']:<52} {row['paper']:<24} {row['ours']}" + ("  UNMET" if row["holds"] is False else ""))
        (self.folder / "summary.json").write_text(json.dumps(self.rows, indent=2) + "\n")
        sys.exit(any(row["holds"] is False for row in self.rows))
