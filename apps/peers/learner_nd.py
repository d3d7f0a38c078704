"""LearnerND of python-adaptive: the simplex of the largest loss is divided next. Its interpolant is piecewise linear.

    python3 learner_nd.py --check      # the ring of its documentation, and its own comparison with a homogeneous grid
"""
import numpy as np
from scipy.interpolate import LinearNDInterpolator

import common
from designs import lattice, need

need("sortedcollections", "python3-sortedcollections")
need("adaptive", "adaptive (python-adaptive)")
from adaptive.learner.learnerND import LearnerND, curvature_loss_function  # noqa: E402


class Learner:
    def __init__(self, low, high, loss=None):
        self.learner = LearnerND(None, list(zip(low.tolist(), high.tolist())), loss_per_simplex=loss)

    def ask(self, n=1):
        return np.array(self.learner.ask(n)[0])

    def tell(self, x, force, stiffness=None):
        self.learner.tell(tuple(x.tolist()), force)

    def predict(self, points):
        data = self.learner.data
        return LinearNDInterpolator(np.array(list(data)), np.array(list(data.values())))(points)


def ring(xy, a=0.2, radius=0.75):
    x, y = xy.T
    return x + np.exp(-((x ** 2 + y ** 2 - radius ** 2) ** 2) / a ** 4)


def check():
    low, high = np.full(2, -1.0), np.ones(2)
    places = np.random.default_rng(0).uniform(low, high, (20000, 2))
    for name, loss, falls in (("default", None, 0.25), ("curvature", curvature_loss_function(), 0.75)):
        learner, losses = Learner(low, high, loss), []
        for n in range(900):
            x = learner.ask()[0]
            learner.tell(x, float(ring(x[None])[0]))
            losses.append(learner.learner.loss())
        yield f"{name} loss, 900 points over 100", losses[899] / losses[99], "<", falls
        near = lambda points: np.mean(abs((points ** 2).sum(axis=1) - 0.75 ** 2) < 0.2 ** 2 * 1.5)
        density = near(np.array(list(learner.learner.data))) / near(places)
        yield f"{name} density near the ring over the mean", density, ">", 2
        grid = lattice(low, high, 900)
        error = lambda made: np.mean(abs(made - ring(places)))
        yield (f"{name} error over that of a grid of as many points",
               error(learner.predict(places)) / error(LinearNDInterpolator(grid, ring(grid))(places)), "<", 0.6)


if __name__ == "__main__":
    curvature = curvature_loss_function()
    common.main({"learner_nd": lambda low, high, seed, n: Learner(low, high),
                 "learner_nd_curvature": lambda low, high, seed, n: Learner(low, high, curvature)}, check)
