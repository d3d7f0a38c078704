"""A policy written in Python, compared with a built-in one in a study.

    python3 own_policy.py SCENE.toml FOLDER

The workers solve fewer states than the hand needs, so it matters which they solve. A registered name exists in this
process alone.
"""
import pathlib
import sys

import numpy as np

import forefeel as ff


class Ahead:
    """States near the predicted path come first."""

    def prioritise(self, candidates, view):
        to_path = view.predicted["at"][:, None, :] - candidates["at"]
        distance = np.linalg.norm(to_path, axis=2).min(axis=0)
        return (view.spacing / (view.spacing + distance)) ** 2


scene_file, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
ff.register_policy("ahead", Ahead)
folder.mkdir(parents=True, exist_ok=True)
(folder / "study.toml").write_text(f"""
scene = "{scene_file}"
seeds = [1]
[session]
seconds = 4.0
cost = "constant:0.2"
[material]
law = "st-venant-kirchhoff"
poisson = 0.3
[vary]
policy = ["nearest", "ahead"]
device = ["path:lissajous,speed=0.06", "path:circle,speed=0.06"]
""")
result = ff.study(folder / "study.toml", folder / "study")
policy = np.asarray(result["cells"]["policy"])
for name in ("nearest", "ahead"):
    share = np.asarray(result["cells"]["error.first_visit.within_jnd"], float)[policy == name].mean()
    print(f"{name}: {100 * share:.1f} % of first visits within the JND")
