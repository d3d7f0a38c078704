"""States from FEniCSx: forefeel asks for positions, a hyperelastic solve of dolfinx tells forces and stiffnesses.

A soft block of 60 x 60 x 40 mm, clamped below, grasped by a patch on its top. Needs python3-dolfinx (0.5) and SciPy.
"""
import dolfinx
import dolfinx.fem.petsc
import numpy as np
import ufl
from mpi4py import MPI
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

import forefeel as ff

block = dolfinx.mesh.create_box(MPI.COMM_SELF, [[-0.03, -0.03, -0.04], [0.03, 0.03, 0.0]], [6, 6, 4],
                                dolfinx.mesh.CellType.hexahedron)                                   # [m]
space = dolfinx.fem.VectorFunctionSpace(block, ("Lagrange", 1))
u = dolfinx.fem.Function(space)                                # displacement [m]
young, poisson = 5000.0, 0.4                                   # [Pa], [1]
mu, lam = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
F = ufl.Identity(3) + ufl.grad(u)
J = ufl.det(F)
density = (mu / 2 * (ufl.tr(F.T * F) - 3) - mu * ufl.ln(J) + lam / 2 * ufl.ln(J) ** 2)        # neo-Hookean [J/m^3]
gradient = ufl.derivative(density * ufl.dx(metadata={"quadrature_degree": 2}), u)
residual, tangent = dolfinx.fem.form(gradient), dolfinx.fem.form(ufl.derivative(gradient, u))

nodes = space.tabulate_dof_coordinates()
dofs = np.arange(3 * len(nodes)).reshape(-1, 3)
patch = (np.abs(nodes[:, 2]) < 1e-9) & (np.linalg.norm(nodes[:, :2], axis=1) < 0.0101)
held = np.abs(nodes[:, 2] + 0.04) < 1e-9
free, contact = dofs[~(patch | held)].ravel(), dofs[patch]
lift = np.zeros((dofs.size, 3))                                # how the patch moves with the tip: as one
for axis in range(3):
    lift[contact[:, axis], axis] = 1


def pull():
    """Derivative of the energy by every displacement [N]."""
    return dolfinx.fem.petsc.assemble_vector(residual).array.copy()


def hessian():
    """The second derivative [N/m]."""
    matrix = dolfinx.fem.petsc.assemble_matrix(tangent)
    matrix.assemble()
    rows, columns, values = matrix.getValuesCSR()
    return csr_matrix((values, columns, rows))


def solver(x):
    """Equilibrium with the patch at x (3,) [m]: force on the tip (3,) [N], stiffness -df/dx (3, 3) [N/m]."""
    steps = max(1, int(np.ceil(np.linalg.norm(x) / 0.004)))
    u.x.array[:] = 0
    for _ in range(steps):
        move = lift @ x / steps                                # the patch first, the rest follows by Newton's method
        for _ in range(25):
            K = hessian()
            move[free] = splu(K[free][:, free].tocsc()).solve(-(pull() + K @ move)[free])
            u.x.array[:] += move
            if np.linalg.norm(pull()[free]) < 1e-10:           # [N]
                break
            move = np.zeros(dofs.size)
        else:
            raise RuntimeError(f"no equilibrium at {x}")
    K = hessian()
    response = lift.copy()
    response[free] = splu(K[free][:, free].tocsc()).solve(-(K @ lift)[free])
    return -lift.T @ pull(), lift.T @ (K @ response)


box = np.array([[-0.01, -0.01, -0.012], [0.01, 0.01, 0.006]])  # [m]
placement = ff.Placement(*box, spacing=0.005)
for _ in range(6):
    for x in placement.ask(4):
        placement.tell(x, *solver(x))

points = np.random.default_rng(0).uniform(*(0.9 * box), (12, 3))
known = placement.states
model = ff.evaluate(known["at"], known["force"], points, known["stiffness"])
truth = np.array([solver(x)[0] for x in points])
error = np.linalg.norm(model - truth, axis=1) / np.maximum(np.linalg.norm(truth, axis=1), 0.05)
print(f"{len(placement)} states of FEniCSx; error of the force at {len(points)} other positions: median "
      f"{100 * np.median(error):.2g} %, largest {100 * error.max():.2g} %")
