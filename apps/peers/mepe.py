"""Maximising the expected prediction error: left-out error of the nearest state, and variance, in a changing balance.

H. Liu, J. Cai, Y.-S. Ong, An adaptive sampling approach for Kriging metamodeling by maximizing expected prediction
error, Comput. Chem. Eng. 106, 2017. The balance follows how well left-out errors told the error of the state before.

    python3 mepe.py --check      # MATLAB's peaks, and a crater, against space filling
"""
import numpy as np
from scipy.spatial import cKDTree

import common
from kriging import KrigingRule, left_out, over_halton, peaks


class Mepe(KrigingRule):
    def balance(self, at, force):
        if self.before is None:
            return 0.5
        true = ((self.before.predict(at[-1:]).reshape(-1) - force[-1]) ** 2).sum()
        told = (left_out(self.before)[cKDTree(at[:-1]).query(at[-1])[1]] ** 2).sum()
        return 0.99 * min(0.5 * true / max(told, 1e-300), 1)

    def value(self, at, force, candidates):
        share = self.balance(at, force)
        deviation = self.model.predict(candidates, return_std=True)[1].reshape(len(candidates), -1)
        return share * self.error_near(at, candidates)[0] + (1 - share) * (deviation ** 2).sum(axis=1)


def crater(x):
    """Of OpenTURNS' test of LOLA-Voronoi."""
    square = (x ** 2).sum(axis=1)
    return 7 * np.exp(-31.25 * square) - 4 * np.exp(-3.125 * square)


def check():
    for function, half in (peaks, 5.0), (crater, 1.0):
        ratio = over_halton(Mepe, function, np.full(2, -half), np.full(2, half), 12, 50)
        yield f"error of 50 states on {function.__name__} over that of Halton's points, median of 5", ratio, "<", 0.8


if __name__ == "__main__":
    common.main({"mepe": Mepe.placed}, check)
