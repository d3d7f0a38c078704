"""P- and f-greedy kernel methods, by the package VKOGA of G. Santin.

P-greedy places states where the power function is largest, whatever the forces. f-greedy chooses among 1000 states that
are all solved beforehand, each time that of the largest residual: it shows what a choice that knows the force reaches,
and its seconds of solving are those of all 1000.

    python3 vkoga_greedy.py --check      # proven rate of P-greedy on its demo's disk; f-greedy on creases
"""
import numpy as np

import common
from designs import Design, halton, need

need("sklearn", "python3-sklearn")
need("vkoga", "vkoga (GabrieleSantin/VKOGA)")
from vkoga.kernels import Matern  # noqa: E402
from vkoga.pgreedy import PGreedy  # noqa: E402
from vkoga.vkoga import VKOGA  # noqa: E402


def fit(points, values, greedy, n, kernel):
    model = VKOGA(kernel=kernel, greedy_type=greedy, tol_f=-1, tol_p=1e-14, verbose=False)
    return model.fit(points, values, maxIter=n)    # of n centres


class Greedy(Design):
    def __init__(self, low, high, seed, n):
        self.low, self.size, self.known = low, high - low, []
        candidates = halton(low, high, 4000, seed)
        order = fit(self.unit(candidates), np.zeros(len(candidates)), "p_greedy", n, Matern(k=2)).indI_
        super().__init__(candidates[order], random=True)

    def unit(self, points):
        return (points - self.low) / self.size

    def tell(self, x, force, *rest):
        self.known.append((x, force))

    def predict(self, points):
        at, force = map(np.array, zip(*self.known))
        return fit(self.unit(at), force, "p_greedy", len(at), Matern(k=2)).predict(self.unit(points))


class Chosen(Greedy):
    pool = 1000

    def __init__(self, low, high, seed, n):
        self.low, self.size = low, high - low
        Design.__init__(self, halton(low, high, self.pool, seed))

    tell = Design.tell

    def chosen(self, states, n):
        model = fit(self.unit(states["at"]), states["force"], "f_greedy", n, Matern(k=2))
        self.predict = lambda points: model.predict(self.unit(points))
        return model.indI_


class Disk:
    d, random = 2, np.random.default_rng(0)    # other points at each step, as in the demo

    def sample(self, n=1000):
        angle, radius = 2 * np.pi * self.random.uniform(size=n), np.sqrt(self.random.uniform(size=n))
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def check():
    for k, rate in ((1, 0.75), (2, 1.25)):    # tau / d - 1/2 with tau = k + (d + 1) / 2, Santin and Haasdonk 2017
        model, steps = PGreedy(kernel=Matern(k=k), max_iter=200, tol_p=1e-14, verbose=False), np.arange(50, 200)
        power = np.sqrt(model.fit(Disk(), 0).predict_max(Disk().sample(10000), 200))
        seen = -np.polyfit(np.log(steps), np.log(power[steps]), 1)[0]
        yield f"relative distance of Matern {k}'s rate from the proven one", abs(seen / rate - 1), "<", 0.25
    points = Disk().sample(4000)
    values = np.stack([abs(points[:, 0] - 0.3), np.hypot(*points.T)], axis=1)    # a crease and a cone
    error = lambda greedy: abs(fit(points, values, greedy, 100, Matern(k=1)).predict(points) - values).max()
    yield "largest error of f-greedy over that of P-greedy", error("f_greedy") / error("p_greedy"), "<", 0.7


if __name__ == "__main__":
    common.main({"vkoga_p_greedy": Greedy, "vkoga_f_greedy_of_1000": Chosen}, check)
