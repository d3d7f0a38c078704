"""Kriging by scikit-learn (python3-sklearn): one Gaussian correlation for all components of the force."""
import warnings

import numpy as np
from scipy.linalg import cho_solve
from scipy.spatial import cKDTree

from designs import Rule, halton, need

need("sklearn", "python3-sklearn")
from sklearn.gaussian_process import GaussianProcessRegressor  # noqa: E402
from sklearn.gaussian_process.kernels import RBF  # noqa: E402


def fitted(at, force, kernel=None):
    """kernel: kept as it is; None: its lengths are chosen by likelihood."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")    # of lengths at their bounds
        return GaussianProcessRegressor(kernel or RBF(np.full(at.shape[1], 0.5), (0.05, 20)), alpha=1e-8,
                                        normalize_y=True, optimizer=None if kernel else "fmin_l_bfgs_b").fit(at, force)


def inverse(model):
    return cho_solve((model.L_, True), np.eye(len(model.L_)))


def left_out(model):
    """Errors (n, c) that each state would have without itself, lengths and mean kept."""
    alpha = model.alpha_.reshape(len(model.L_), -1)
    return alpha / np.diag(inverse(model))[:, None] * model._y_train_std


class KrigingRule(Rule):
    """Chooses lengths at every fifth state. predict() is the interpolant of the states so far."""

    def __init__(self):
        self.model = self.asked = None

    def worth(self, at, force, candidates):
        keep = self.model is not None and len(at) % 5
        self.before, self.model = self.model, fitted(at, force, self.model.kernel_ if keep else None)
        return self.value(at, force, candidates)

    def predict(self, points):
        return self.model.predict(self.unit(points))

    def error_near(self, at, candidates):
        """Squared left-out error of the state whose cell a candidate is in (m,), and the distance to it."""
        gaps, cell = cKDTree(at).query(candidates)
        return (left_out(self.model) ** 2).sum(axis=1)[cell], gaps, cell


def peaks(x):
    """MATLAB's, on [-3, 3]^2."""
    u, v = x.T
    return (3 * (1 - u) ** 2 * np.exp(-u ** 2 - (v + 1) ** 2)
            - 10 * (u / 5 - u ** 3 - v ** 5) * np.exp(-u ** 2 - v ** 2) - np.exp(-(u + 1) ** 2 - v ** 2) / 3)


def over_halton(rule, function, low, high, start, n, seeds=5):
    """Root mean square error of kriging on a rule's n states over that on n of Halton's points; median of seeds."""
    places = np.random.default_rng(0).uniform(low, high, (4000, len(low)))

    def error(at):
        model = fitted((at - low) / (high - low), function(at))
        return np.sqrt(np.mean((model.predict((places - low) / (high - low)) - function(places)) ** 2))

    return np.median([error(rule().grow(function, low, high, halton(low, high, start, seed), n))
                      / error(halton(low, high, n, seed)) for seed in range(seeds)])
