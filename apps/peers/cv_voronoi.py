"""Cross-validation and Voronoi cells: in the cell of the largest left-out error, the place farthest from its state.

S. Xu, H. Liu, X. Wang, X. Jiang, A robust error-pursuing sequential sampling approach for global metamodeling based on
Voronoi diagram and cross validation, J. Mech. Des. 136(7), 2014. Cells are of the candidates; errors are left out with
the lengths of kriging kept.

    python3 cv_voronoi.py --check      # left-out errors against refits; MATLAB's peaks against space filling
"""
import numpy as np

import common
from designs import halton
from kriging import GaussianProcessRegressor, KrigingRule, fitted, left_out, over_halton, peaks


class CvVoronoi(KrigingRule):
    def value(self, at, force, candidates):
        error, gaps, cell = self.error_near(at, candidates)
        return np.where(error == error.max(), gaps, 0)


def check():
    low, high = np.full(2, -5.0), np.full(2, 5.0)
    at = halton(np.zeros(2), np.ones(2), 25, 0)
    force = peaks(low + (high - low) * at)
    force = ((force - force.mean()) / force.std())[:, None]
    model = fitted(at, force)
    alone = GaussianProcessRegressor(model.kernel_, alpha=1e-8, optimizer=None)
    refits = [force[i] - alone.fit(np.delete(at, i, 0), np.delete(force, i, 0)).predict(at[[i]])[0] for i in range(25)]
    yield "left-out errors less those of refits", abs(left_out(model) - refits).max(), "<", 1e-5
    yield ("error of 50 states on peaks over that of Halton's points, median of 5",
           over_halton(CvVoronoi, peaks, low, high, 12, 50), "<", 0.7)


if __name__ == "__main__":
    common.main({"cv_voronoi": CvVoronoi.placed}, check)
