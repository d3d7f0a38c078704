"""A pad beside a rigid sphere that only pushes, by FEniCSx. Usage: pad_and_sphere.py [CELLS]

A cylinder of radius 8 cm and height 6 cm, neo-Hookean, 5 kPa, Poisson's ratio 0.45, clamped at its bottom, in axial
symmetry with quadratic elements. The pad has 1000 N/m and 20 mm. The sphere has 36 mm, so that at 10 mm it touches
a disc of about 20 mm; it has no friction, and a penalty of 1e8 N/m^3 keeps the surface out of it."""
import sys

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

RADIUS, HEIGHT, YOUNG, POISSON = 0.08, 0.06, 5000.0, 0.45
PAD_RADIUS, PAD_STIFFNESS, SPHERE_RADIUS, PENALTY = 0.02, 1000.0, 0.036, 1e8
STEP = 0.0005  # of the depth [m]

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 24
grid = mesh.create_rectangle(MPI.COMM_SELF, [[0, 0], [1, 1]], [cells, cells])
s, t = grid.geometry.x[:, 0].copy(), grid.geometry.x[:, 1].copy()
grid.geometry.x[:, 0] = RADIUS * (0.35 * s + 0.65 * s ** 2.2)  # smaller cells under the contact
grid.geometry.x[:, 1] = HEIGHT * (1 - 0.3 * (1 - t) - 0.7 * (1 - t) ** 1.8)

space = fem.VectorFunctionSpace(grid, ("Lagrange", 2))
u, test, trial = fem.Function(space), ufl.TestFunction(space), ufl.TrialFunction(space)
x = ufl.SpatialCoordinate(grid)
r, g = x[0], ufl.grad(u)
F = ufl.as_tensor([[1 + g[0, 0], 0, g[0, 1]], [0, 1 + u[0] / r, 0], [g[1, 0], 0, 1 + g[1, 1]]])
J = ufl.det(F)
mu, lam = YOUNG / 2 / (1 + POISSON), YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
psi = mu / 2 * (ufl.tr(F.T * F) - 3) - mu * ufl.ln(J) + lam / 2 * ufl.ln(J) ** 2
top = np.sort(mesh.locate_entities_boundary(grid, 1, lambda p: np.isclose(p[1], HEIGHT)))
tags = mesh.meshtags(grid, 1, top, np.ones(len(top), dtype=np.int32))
dx = ufl.Measure("dx", domain=grid, metadata={"quadrature_degree": 5})
ds = ufl.Measure("ds", domain=grid, subdomain_data=tags, metadata={"quadrature_degree": 12})(1)
ring = 2 * np.pi * r
depth = fem.Constant(grid, 0.0)


def unknowns(where, components):
    nodes = fem.locate_dofs_geometrical(space, where)
    return np.concatenate([2 * nodes + c for c in components])


bottom = unknowns(lambda p: np.isclose(p[1], 0), [1])
fixed = np.concatenate([bottom, unknowns(lambda p: np.isclose(p[1], 0) | np.isclose(p[0], 0), [0])])
free = np.setdiff1d(np.arange(u.x.array.size), fixed)


def forces(contact):
    """Force on the tip [N] at each step to 15.5 mm, the reaction of the clamp."""
    def gradient(form):
        return fem.petsc.assemble_vector(form).array.copy()

    derivative = ufl.derivative(psi * ring * dx + contact, u, test)
    residual, tangent = fem.form(derivative), fem.form(ufl.derivative(derivative, u, trial))
    body = fem.form(ufl.derivative(psi * ring * dx, u, test))
    u.x.array[:] = 0
    found = []
    for step in range(1, 32):
        depth.value = step * STEP
        for iteration in range(60):
            before = gradient(residual)
            matrix = fem.petsc.assemble_matrix(tangent)
            matrix.assemble()
            start, column, value = matrix.getValuesCSR()
            h = scipy.sparse.csr_matrix((value, column, start))
            move = scipy.sparse.linalg.spsolve(h[free][:, free].tocsc(), -before[free])
            old = u.x.array.copy()
            while True:
                u.x.array[free] = old[free] + move
                after = gradient(residual)
                if np.isfinite(after).all() and (iteration == 0 or np.abs(move).max() < 1e-9
                                                 or np.linalg.norm(after[free]) < np.linalg.norm(before[free])):
                    break
                move = move / 2
            if np.abs(move).max() < 1e-11:
                break
        else:
            sys.exit("Newton's method does not converge")
        found.append(gradient(body)[bottom].sum())
    return np.array(found)


fall = ufl.max_value(0.0, 1 - r ** 2 / PAD_RADIUS ** 2)
density = 3 * PAD_STIFFNESS / (np.pi * PAD_RADIUS ** 2) * fall ** 2
away = u + ufl.as_vector([0, depth])
place = ufl.as_vector([r + u[0], x[1] + u[1] - (HEIGHT + SPHERE_RADIUS - depth)])
overlap = ufl.max_value(0.0, SPHERE_RADIUS - ufl.sqrt(ufl.dot(place, place)))
print("contact  depth [mm]  force [N]  stiffness [N/m]")
for name, contact in (("pad", density / 2 * ufl.dot(away, away) * ring * ds),
                      ("sphere", PENALTY / 2 * overlap ** 2 * ring * ds)):
    f = forces(contact)
    for millimetres in (5, 10, 15):
        k = 2 * millimetres - 1
        print(f"{name:7}  {millimetres:10}  {f[k]:9.4f}  {(f[k + 1] - f[k - 1]) / (2 * STEP):15.1f}")
