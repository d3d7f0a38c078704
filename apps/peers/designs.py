"""Baselines, rules for forefeel.Placement, and functions that checks use."""
import importlib
import pathlib
import sys

import numpy as np
from scipy.stats import qmc


def need(module, package=None):
    """The module, or one line that names the package, and exit code 2."""
    try:
        return importlib.import_module(module)
    except ImportError as problem:
        print(f"{pathlib.Path(sys.argv[0]).name}: needs the package {package or module} ({problem})", file=sys.stderr)
        sys.exit(2)


class Design:
    """Positions that are known before any force."""

    def __init__(self, points, random=False):
        self.points, self.random, self.asked = points, random, 0

    def ask(self, n=1):
        self.asked += n
        return self.points[self.asked - n:self.asked]

    def tell(self, *state):
        pass


def lattice(low, high, n):    # n: a cube or square
    sides = np.linspace(low, high, round(n ** (1 / len(low)))).T
    return np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, len(low))


def halton(low, high, n, seed):
    return qmc.scale(qmc.Halton(len(low), seed=seed).random(n), low, high)


def farthest(low, high, n):    # each from all before it, on a fine lattice
    fine = lattice(low, high, 21 ** len(low))
    chosen, gaps = [(low + high) / 2], np.inf
    while len(chosen) < n:
        gaps = np.minimum(gaps, np.linalg.norm(fine - chosen[-1], axis=1))
        chosen.append(fine[gaps.argmax()])
    return np.array(chosen)


def baselines():
    ff = need("forefeel")
    return {"lattice": lambda low, high, seed, n: Design(lattice(low, high, n)),
            "halton": lambda low, high, seed, n: Design(halton(low, high, n, seed), random=True),
            "farthest": lambda low, high, seed, n: Design(farthest(low, high, n)),
            "forefeel": lambda low, high, seed, n: ff.Placement(low, high, max(high - low) / 12)}


class Rule:
    """worth(at, force, candidates) (m,): what to solve next, from the states in the unit box; the largest is asked."""

    def doubt(self, states, candidates):
        if len(states["at"]) < 8:    # Placement's own
            return np.ones(len(candidates))
        self.low, self.size = candidates.min(axis=0), np.ptp(candidates, axis=0)
        at, force = self.unit(states["at"]), states["force"].reshape(len(states["at"]), -1)
        return self.worth(at, force, self.unit(candidates))

    def unit(self, points):
        return (points - self.low) / self.size

    @classmethod
    def placed(cls, low, high, seed, n):
        rule = cls()
        sampler = need("forefeel").Placement(low, high, max(high - low) / 12, rule=rule)
        if hasattr(cls, "predict"):    # of all states, the last included
            sampler.predict = lambda points: [rule.doubt(sampler.states, sampler.candidates), rule.predict(points)][1]
        return sampler

    def grow(self, function, low, high, start, n):
        """(n, d): start (k, d), then what the rule asks of a function, among 5000 candidates. For checks."""
        candidates, at = halton(low, high, 5000, 1), np.array(start)
        while len(at) < n:
            worth = self.doubt({"at": at, "force": function(at)}, candidates)
            at = np.vstack([at, candidates[worth.argmax()]])
        return at
