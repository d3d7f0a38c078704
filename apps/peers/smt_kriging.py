"""SMT: Latin hypercubes by enhanced stochastic evolution, and kriging (KRG) that asks where its variance is largest.

One KRG for each component of the force; lengths are chosen at every 25th state.

    python3 smt_kriging.py --check      # the distances of its Latin hypercubes; kriging on its Branin problem
"""
import numpy as np
from scipy.spatial.distance import pdist

import common
from designs import Design, Rule, need

need("smt.surrogate_models", "smt (Surrogate Modeling Toolbox)")
from smt.problems import Branin  # noqa: E402
from smt.sampling_methods import LHS  # noqa: E402
from smt.surrogate_models import KRG  # noqa: E402


def hypercube(low, high, n, seed, criterion="ese"):
    return LHS(xlimits=np.stack([low, high], axis=1), criterion=criterion, seed=seed)(n)


def trained(at, value, theta=None):
    """theta: kept as it is; None: chosen by likelihood."""
    chosen = {"theta0": [1.0] * at.shape[1], "n_start": 3}
    model = KRG(print_global=False, seed=0, **chosen if theta is None else {"theta0": theta, "hyper_opt": "NoOp"})
    model.set_training_values(at, value[:, None])
    model.train()
    return model


class Variance(Rule):
    models = ()

    def worth(self, at, force, candidates):
        if not self.models or len(at) % 25 == 0:
            self.theta = [np.clip(trained(at, value).optimal_theta, 1e-6, 20) for value in force.T]    # its bounds
        self.models = [trained(at, value, theta) for value, theta in zip(force.T, self.theta)]
        return sum(model.predict_variances(candidates)[:, 0] for model in self.models)

    def predict(self, points):
        return np.hstack([model.predict_values(self.unit(points)) for model in self.models])


def check():
    unit = np.zeros(3), np.ones(3)
    apart = lambda criterion: np.median([pdist(hypercube(*unit, 60, seed, criterion)).min() for seed in range(5)])
    yield "least distance in an evolved hypercube over that in a plain one", apart("ese") / apart("c"), ">", 2
    low, high = Branin(ndim=2).xlimits.T
    branin, places = lambda x: Branin(ndim=2)(x)[:, 0], np.random.default_rng(0).uniform(low, high, (2000, 2))

    def error(at):
        model = trained((at - low) / (high - low), branin(at))
        return np.sqrt(np.mean((model.predict_values((places - low) / (high - low))[:, 0] - branin(places)) ** 2))

    errors = np.array([[error(Variance().grow(branin, low, high, hypercube(low, high, 12, seed), 40)),
                        error(hypercube(low, high, 40, seed, "c"))] for seed in range(5)])
    yield ("error of 40 states over that of a plain Latin hypercube, median of 5",
           np.median(errors[:, 0] / errors[:, 1]), "<", 0.6)


if __name__ == "__main__":
    common.main({"smt_lhs": lambda low, high, seed, n: Design(hypercube(low, high, n, seed), random=True),
                 "smt_variance": Variance.placed}, check)
