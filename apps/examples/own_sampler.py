"""A sampler written in Python, compared with built-in designs in a study: own_sampler.py SCENE.toml FOLDER"""
import pathlib
import sys

import numpy as np

import forefeel as ff

scene, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
low, high, spacing = np.full(3, -0.018), np.full(3, 0.018), 0.006  # [m]

# As many places as the other designs have: rest, then the additive sequence of the root of g^4 = g + 1 (Roberts 2018).
count, g = round(np.prod((high - low) / spacing)), 1.2207440846057596
share = (0.5 + np.arange(1, count)[:, None] / g ** np.arange(1, 4)) % 1
places = np.vstack([np.zeros(3), low + share * (high - low)])
np.savetxt(folder / "places.csv", places, delimiter=",", header="x,y,z", comments="")

(folder / "study.toml").write_text(f"""
scene = "{scene}"
seeds = [1]
session = {{ seconds = 4.0, cost = "constant:0.2", placement = "lattice" }}
state_space = {{ spacing = {spacing}, box = {[low.tolist(), high.tolist()]} }}
[vary]
"state_space.design" = ["lattice", "halton", "list:places.csv"]
device = ["path:lissajous,speed=0.06", "path:reach,speed=0.06", "path:palpation,speed=0.06", "path:tour,speed=0.06"]
""")
cells = ff.study(folder / "study.toml", folder / "study")["cells"]
designs, share = np.asarray(cells["state_space.design"]), np.asarray(cells["error.first_visit.within_jnd"], float)
for name in dict.fromkeys(designs):
    print(f"{name}: {100 * share[designs == name].mean():.1f} % of first visits within the JND")
