"""A predictor written in Python, compared with built-in ones in a study: own_predictor.py SCENE.toml FOLDER"""
import pathlib
import sys

import numpy as np

import forefeel as ff


class Slowing:
    """The hand goes on and comes to rest: its velocity fades with a time constant."""

    def __init__(self, tau="0.3"):
        self.tau, self.at, self.velocity = float(tau), np.zeros(3), np.zeros(3)

    def observe(self, t, at, velocity):
        self.at, self.velocity = at, velocity

    def predict(self, horizon):
        way = self.tau * (1 - np.exp(-horizon / self.tau)) * self.velocity
        return self.at + way, 5e-4 + 0.5 * horizon * np.sqrt(self.velocity @ self.velocity)


scene, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
ff.register_predictor("slowing", Slowing)
folder.mkdir(parents=True, exist_ok=True)
(folder / "study.toml").write_text(f"""
scene = "{scene}"
seeds = [1]
session = {{ seconds = 4.0, cost = "constant:0.2" }}
[vary]
"session.predictor" = ["kalman", "constant-velocity", "slowing", "slowing:tau=0.1"]
device = ["path:lissajous,speed=0.06", "path:reach,speed=0.06", "path:palpation,speed=0.06", "path:tour,speed=0.06"]
""")
cells = ff.study(folder / "study.toml", folder / "study")["cells"]
names = np.asarray(cells["session.predictor"])
for name in dict.fromkeys(names):
    mean = lambda key: np.asarray(cells["prediction.ms100." + key], float)[names == name].mean()
    p95, within = mean("p95"), mean("within_90")
    print(f"{name}: 95 % within {1e3 * p95:.2g} mm at 0.1 s; {100 * within:.0f} % in the ball of 90 %")
