"""How far is a force right beyond the known states? The three situations of the paper's Fig. 2, on any scene.

    python3 fig2.py SCENE.toml OUT.png

The tip moves 6 cm into the body. All states before the start are known; beyond it none (blank), none up to a far
side (gap), or fewer and fewer (sparse). Each point uses the 100 nearest known states, as in the paper.
apps/paper/extrapolation.py shows lower errors; it knows 5 spacings around the path, not 3, and compares with tight
solves, not with the model of all states.
"""
import sys

import numpy as np

import forefeel as ff

scene = ff.Scene(sys.argv[1])
h = scene.spacing                                              # [m]
inward = np.array([0, 0, -1.0])
depth, far_side = 10, 8                                        # of the path and of the gap, in spacings
# %% Every state of the lattice around the path: what "completely known" means
complete = scene.body.generate(h, [[-3 * h, -3 * h, -depth * h], [3 * h, 3 * h, 3 * h]])
states = complete.array[complete.usable]
layer = np.rint(states["at"] @ inward / h)                     # 0 at the start of the path

# %% What each situation leaves of it
drawn = np.random.default_rng(1).uniform(size=len(states))
known = {"blank": layer <= 0,
         "gap": (layer <= 0) | (layer >= far_side),
         "sparse": (layer <= 0) | (drawn < 0.5 * (1 - layer / (depth + 1)))}

# %% Forces along the path
s = np.linspace(0, depth * h, 121)                             # [m]
path = s[:, None] * inward


def forces(mask, kernel):
    kept = states[mask]
    return ff.evaluate(kept["at"], kept["force"], path, method="rbf", kernel=kernel, neighbours=100, select="nearest")


truth = forces(np.full(len(states), True), "cubic")
size = np.maximum(np.linalg.norm(truth, axis=1), 0.05)         # [N]
curves = {name: forces(mask, "cubic") for name, mask in known.items()}
error = {name: np.linalg.norm(force - truth, axis=1) / size for name, force in curves.items()}
for name, values in error.items():
    label = ff.label_names[ff.classify(states["at"][known[name]], path[[60]], h)[0]]
    print(f"{name}: error {100 * values[60]:.2g} % halfway ({label}), {100 * values.max():.2g} % at most")

# %% The figure
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
left.plot(1e3 * s, np.linalg.norm(truth, axis=1), "k--", zorder=3, label="completely known")
for name in curves:
    left.plot(1e3 * s, np.linalg.norm(curves[name], axis=1), label=name)
    right.semilogy(1e3 * s, np.maximum(100 * error[name], 1e-4), label=name)
left.set(xlabel="displacement [mm]", ylabel="force [N]", title="Force")
right.set(xlabel="displacement [mm]", ylabel="relative error [%]", title="Error")
left.legend()
figure.savefig(sys.argv[2], dpi=150)
