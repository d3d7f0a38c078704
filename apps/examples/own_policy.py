"""A policy written in Python, compared with a built-in one in a study, and what each costs per plan.

    python3 own_policy.py SCENE.toml FOLDER
"""
import pathlib
import sys
import time

import numpy as np

import forefeel as ff


class Ahead:
    """States near the predicted path come first."""

    def prioritise(self, candidates, view):
        to_path = view.predicted["at"][:, None, :] - candidates["at"]
        distance = np.linalg.norm(to_path, axis=2).min(axis=0)
        return (view.spacing / (view.spacing + distance)) ** 2


class Timed(Ahead):
    """The same; asks the built-in policy about the same candidates and compares the time."""

    def __init__(self):
        self.python, self.built_in, self.count = [], [], []

    def prioritise(self, candidates, view):
        begin = time.perf_counter()
        mine = super().prioritise(candidates, view)
        middle = time.perf_counter()
        view.prioritise("nearest", candidates)
        self.built_in.append(time.perf_counter() - middle)
        self.python.append(middle - begin)
        self.count.append(len(candidates))
        return mine


scene_file, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
ff.register_policy("ahead", Ahead)
folder.mkdir(parents=True, exist_ok=True)
(folder / "study.toml").write_text(f"""
scene = "{scene_file}"
seeds = [1, 2]
[session]
seconds = 1.0
device = "path:circle,speed=0.04"
cost = "constant:0.02"
[vary]
policy = ["nearest", "ahead"]
""")
result = ff.study(folder / "study.toml", folder / "study")
policy = np.asarray(result["cells"]["policy"])
for name in ("nearest", "ahead"):
    share = np.asarray(result["cells"]["error.first_visit.within_jnd"], float)[policy == name].mean()
    print(f"{name}: {100 * share:.1f} % of first visits within the JND")

timed = Timed()
ff.Scene(scene_file).session(policy=timed, clock="virtual", seconds=1, device="path:circle,speed=0.04",
                             cost="constant:0.02")
print(f"per plan, {np.median(timed.count):.0f} candidates: Python {1e6 * np.median(timed.python):.0f} us, "
      f"built-in {1e6 * np.median(timed.built_in):.0f} us")
