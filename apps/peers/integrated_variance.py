"""Active learning of Cohn (ALC, IMSE): the state that lowers the mean variance of a Gaussian process most.

D. Cohn, Neural network exploration using optimal experiment design, Neural Networks 9(6), 1996; the process is
scikit-learn's. The mean is over 500 places.

    python3 integrated_variance.py --check      # variances that scikit-learn tells afterwards; Branin's function
"""
import numpy as np
from scipy.linalg import solve_triangular

import common
from designs import halton
from kriging import KrigingRule, fitted, over_halton


def lowered(model, candidates, places):
    """By how much a state at each candidate (m,) would lower the mean variance at places, without units."""
    known, kernel = model.X_train_, model.kernel_
    half = [solve_triangular(model.L_, kernel(known, points), lower=True) for points in (candidates, places)]
    left = kernel.diag(candidates) - (half[0] ** 2).sum(axis=0) + model.alpha
    return ((kernel(places, candidates) - half[1].T @ half[0]) ** 2).mean(axis=0) / left


class IntegratedVariance(KrigingRule):
    def value(self, at, force, candidates):
        size = candidates.shape[1]
        return lowered(self.model, candidates, halton(np.zeros(size), np.ones(size), 500, 0))


def branin(x):
    u, v = x.T
    return ((v - 5.1 / (4 * np.pi ** 2) * u ** 2 + 5 / np.pi * u - 6) ** 2
            + 10 * (1 - 1 / (8 * np.pi)) * np.cos(u) + 10)


def check():
    low, high, unit = np.array([-5.0, 0]), np.array([10.0, 15]), (np.zeros(2), np.ones(2))
    at, new, places = halton(*unit, 20, 0), halton(*unit, 5, 1), halton(*unit, 300, 2)
    value = branin(low + (high - low) * at)
    model = fitted(at, value)
    variance = lambda model: np.mean(model.predict(places, return_std=True)[1] ** 2) / model._y_train_std ** 2
    after = [variance(model) - variance(fitted(np.vstack([at, x]), np.append(value, 0), model.kernel_)) for x in new]
    told = lowered(model, new, places)
    yield "fall of the variance against scikit-learn's own", abs(told / after - 1).max(), "<", 1e-3
    yield ("error of 50 states on Branin's function over that of Halton's points, median of 5",
           over_halton(IntegratedVariance, branin, low, high, 12, 50), "<", 0.7)


if __name__ == "__main__":
    common.main({"integrated_variance": IntegratedVariance.placed}, check)
