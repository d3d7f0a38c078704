"""LOLA-Voronoi: more states where the force bends and where cells are large.

K. Crombecq, D. Gorissen, D. Deschrijver, T. Dhaene, A novel hybrid sequential design strategy for global surrogate
modeling of computer experiments, SIAM J. Sci. Comput. 33(4), 2011. Volumes of Voronoi cells are counted by candidates.
OpenTURNS has another implementation, in releases later than Debian 12's.

    python3 lola_voronoi.py --check      # cross-polytopes and planes; Hartmann's function in three dimensions
"""
import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

import common
from designs import Rule, halton


def score(away):
    """S = R / C of neighbourhoods (k, m, d), relative to their state; and R, 1 for a cross-polytope."""
    cohesion = np.linalg.norm(away, axis=2).mean(axis=1)
    between = np.linalg.norm(away[:, :, None] - away[:, None], axis=3) + 1e9 * np.eye(away.shape[1])
    cross = between.min(axis=2).mean(axis=1) / (np.sqrt(2) * cohesion)
    return cross / cohesion, cross


class LolaVoronoi(Rule):
    def __init__(self):
        self.near = []

    def offer(self, at, state, other):
        """Takes `other` among the neighbours of a state if one of them serves worse."""
        sets = np.array([self.near[state]] + [np.where(np.arange(len(self.near[state])) == k, other, self.near[state])
                                              for k in range(len(self.near[state]))])
        self.near[state] = sets[score(at[sets] - at[state])[0].argmax()]

    def bend(self, at, force):
        """E: what the neighbours' forces differ by from the plane that fits them."""
        wanted = 2 * at.shape[1]
        for new in range(len(self.near), len(at)):
            others = np.delete(np.arange(max(new, wanted) + 1), new)
            self.near.append(others[:wanted])
            for other in others[wanted:]:
                self.offer(at, new, other)
            for old in range(new):
                if new not in self.near[old]:
                    self.offer(at, old, new)
        bends = []
        for state, near in enumerate(self.near):
            away, rise = at[near] - at[state], force[near] - force[state]
            bends.append(np.linalg.norm(rise - away @ np.linalg.lstsq(away, rise, rcond=None)[0], axis=1).sum())
        return np.array(bends)

    def worth(self, at, force, candidates):
        bend, cell = self.bend(at, force), cKDTree(at).query(candidates)[1]
        volume = np.bincount(cell, minlength=len(at)) / len(candidates)
        best = (volume + bend / max(bend.sum(), 1e-300)).argmax()
        return np.where(cell == best, cKDTree(at[[best, *self.near[best]]]).query(candidates)[0], 0)


def hartmann(x):
    a = np.array([[3, 10, 30], [0.1, 10, 35], [3, 10, 30], [0.1, 10, 35]])
    p = 1e-4 * np.array([[3689, 1170, 2673], [4699, 4387, 7470], [1091, 8732, 5547], [381, 5743, 8828]])
    return -np.exp(-(a * (x[:, None] - p) ** 2).sum(axis=2)) @ [1, 1.2, 3, 3.2]


def check():
    axes = np.vstack([np.eye(3), -np.eye(3)])
    yield "cross-polytope ratio of the axes", abs(score(axes[None])[1][0] - 1), "<", 1e-12
    at = halton(np.zeros(3), np.ones(3), 40, 0)
    yield "bend of a plane", LolaVoronoi().bend(at, at @ [[1.0], [2], [3]]).max(), "<", 1e-12
    places = np.random.default_rng(0).uniform(size=(4000, 3))
    error = lambda at: np.sqrt(np.mean((RBFInterpolator(at, hartmann(at))(places) - hartmann(places)) ** 2))
    ratios = []
    for seed in range(5):
        grown = LolaVoronoi().grow(hartmann, np.zeros(3), np.ones(3), halton(np.zeros(3), np.ones(3), 20, seed), 120)
        ratios.append(error(grown) / error(halton(np.zeros(3), np.ones(3), 120, seed)))
    yield "error on Hartmann's function over that of Halton's points, median of 5", np.median(ratios), "<", 0.9


if __name__ == "__main__":
    common.main({"lola_voronoi": LolaVoronoi.placed}, check)
