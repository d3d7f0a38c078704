"""States from a solver of one's own: forefeel asks for positions, the solver tells forces and stiffnesses.

The solver here is a chain of four nonlinear springs in series, solved by SciPy; FEniCSx, a measurement or any other
source fits the same loop.
"""
import numpy as np
from scipy.optimize import root

import forefeel as ff

rest = np.array([0, 0, 0.02])                                  # of each spring [m]
stiff, harder = 400.0, 3e5                                     # [N/m], [N/m^3]


def pull(d):
    """Force of a spring on its lower end [N], with the upper end moved by d (3,) [m] relative to it."""
    length = np.linalg.norm(rest + d)
    stretch = length - np.linalg.norm(rest)
    return (stiff * stretch + harder * stretch ** 3) * (rest + d) / length + 30 * d


def solver(x):
    """Equilibrium with the tip at x (3,) [m]: force on the tip (3,) [N], stiffness -df/dx (3, 3) [N/m]."""
    def residual(nodes, tip=x):
        ends = np.vstack([np.zeros(3), nodes.reshape(3, 3), tip])
        pulls = np.array([pull(d) for d in np.diff(ends, axis=0)])
        return (pulls[1:] - pulls[:-1]).ravel()

    def force(tip):
        inner = root(residual, np.outer([0.25, 0.5, 0.75], tip).ravel(), args=(tip,), tol=1e-12).x
        return -pull(tip - inner[6:])

    step = 1e-6                                                # [m]
    return force(x), -np.array([(force(x + step * e) - force(x - step * e)) / (2 * step) for e in np.eye(3)]).T


box = np.array([[-0.02, -0.02, -0.02], [0.02, 0.02, 0.02]])    # [m]
placement = ff.Placement(*box, spacing=0.005)
for _ in range(10):
    for x in placement.ask(4):
        placement.tell(x, *solver(x))

points = np.random.default_rng(0).uniform(*(0.9 * box), (40, 3))
known = placement.states
model = ff.evaluate(known["at"], known["force"], points, known["stiffness"])
truth = np.array([solver(x)[0] for x in points])
error = np.linalg.norm(model - truth, axis=1) / np.maximum(np.linalg.norm(truth, axis=1), 0.05)
print(f"{len(placement)} states; error of the force at {len(points)} other positions: median "
      f"{100 * np.median(error):.2g} %, largest {100 * error.max():.2g} %")
