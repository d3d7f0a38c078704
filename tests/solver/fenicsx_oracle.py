"""Forces of bodies on the tip, by FEniCSx: BODIES.json OUT.json

BODIES.json: a list of bodies, each with nodes (#V x 3), tets (#T x 4), law (#T: 0 linear, 1 St. Venant-Kirchhoff,
2 neo-Hookean), mu and lambda (#T), degree (1 or 2), clamp_nodes (#C), at (#S x 3), steps, and contact (a box
[[x0, y0, z0], [x1, y1, z1]] that holds its nodes) or pad: {nodes (#P x 3), springs (#Q x [i, j, M_ij])} with
the energy 1/2 w^T M w over the nodes' displacements w_0 .. w_(P-1) and the tip's w_P = x; j >= i, M is symmetric.
OUT.json: for each body its forces (#S x 3)."""
import itertools
import json
import sys

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
import scipy.spatial
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc


def solve(body):
    cell = ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
    grid = mesh.create_mesh(MPI.COMM_SELF, np.array(body["tets"], dtype=np.int64),
                            np.array(body["nodes"], dtype=np.float64), ufl.Mesh(cell))
    order = np.array(grid.topology.original_cell_index)

    def by_cell(values):
        field = fem.Function(fem.FunctionSpace(grid, ("DG", 0)))
        field.x.array[:] = np.array(values, dtype=float)[order]
        return field

    law = np.array(body["law"])
    is_law = [by_cell(law == number) for number in range(3)]
    mu, lam = by_cell(body["mu"]), by_cell(body["lambda"])

    space = fem.VectorFunctionSpace(grid, ("Lagrange", body["degree"]))
    u, test, trial = fem.Function(space), ufl.TestFunction(space), ufl.TrialFunction(space)
    F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
    J, C, small = ufl.det(F), F.T * F, (F + F.T) / 2 - ufl.Identity(3)
    green = (C - ufl.Identity(3)) / 2

    def quadratic(strain):
        return lam / 2 * ufl.tr(strain) ** 2 + mu * ufl.inner(strain, strain)

    psi = (is_law[0] * quadratic(small) + is_law[1] * quadratic(green)
           + is_law[2] * (mu / 2 * (ufl.tr(C) - 3) - mu * ufl.ln(J) + lam / 2 * ufl.ln(J) ** 2))
    dx = ufl.Measure("dx", domain=grid,
                     metadata={"quadrature_degree": 0 if body["degree"] == 1 else 2})
    residual_form = ufl.inner(ufl.diff(psi, F), ufl.grad(test)) * dx
    residual = fem.form(residual_form)
    tangent = fem.form(ufl.derivative(residual_form, u, trial))

    def unknowns(box):
        if box is None:
            return np.empty(0, dtype=int)
        low, high = np.array(box[0]) - 1e-9, np.array(box[1]) + 1e-9
        nodes = fem.locate_dofs_geometrical(
            space, lambda x: np.all((x.T >= low) & (x.T <= high), axis=1))
        return (3 * nodes[:, None] + np.arange(3)).ravel()

    # The pad's gradient is springs @ u + to_tip @ x, and minus its force on the tip is to_tip.T @ u + of_tip x.
    def pad_matrices(pad):
        count, places = len(pad["nodes"]), space.tabulate_dof_coordinates()
        distance, node = scipy.spatial.cKDTree(places).query(pad["nodes"])
        assert distance.max() < 1e-9
        node = np.append(node, len(places))  # the tip comes last
        i, j, value = np.array(pad["springs"]).T
        i, j = node[i.astype(int)], node[j.astype(int)]
        upper = scipy.sparse.csr_matrix((value, (i, j)), shape=(len(places) + 1,) * 2)
        whole = scipy.sparse.kron(upper + scipy.sparse.triu(upper, 1).T + scipy.sparse.tril(upper, -1).T,
                                  scipy.sparse.identity(3), format="csr")
        assert node.max() == len(places) and count == len(set(node[:-1]))
        return whole[:-3, :-3], whole[:-3, -3:], whole[-3:, -3:]

    # Those of the nodes and, of quadratic elements, of the middles of the edges between two of them.
    def unknowns_of_nodes(nodes):
        places = np.array(body["nodes"])[nodes]
        if body["degree"] == 2:
            pairs = np.array(body["tets"])[:, list(itertools.combinations(range(4), 2))].reshape(-1, 2)
            ends = np.array(body["nodes"])[pairs[np.isin(pairs, nodes).all(axis=1)]]
            places = np.concatenate([places, ends.mean(axis=1)])
        distance, node = scipy.spatial.cKDTree(space.tabulate_dof_coordinates()).query(places)
        assert distance.max() < 1e-12
        return (3 * np.unique(node)[:, None] + np.arange(3)).ravel()

    clamp, contact = unknowns_of_nodes(body["clamp_nodes"]), unknowns(body.get("contact"))
    pad = pad_matrices(body["pad"]) if "pad" in body else None
    free = np.setdiff1d(np.arange(u.x.array.size), np.concatenate([clamp, contact]))

    def gradient(x):
        vector = fem.petsc.assemble_vector(residual)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return vector.array + (pad[0] @ u.x.array + pad[1] @ x if pad else 0)

    def force(x):
        if pad:
            return -(pad[1].T @ u.x.array + pad[2] @ x)
        return -gradient(x)[contact].reshape(-1, 3).sum(axis=0)

    # A full step of Newton's method, with the contact moved to x first.
    def step_to(x):
        move = np.zeros_like(u.x.array)
        move[contact] = np.tile(x, contact.size // 3) - u.x.array[contact]
        matrix = fem.petsc.assemble_matrix(tangent)
        matrix.assemble()
        start, column, value = matrix.getValuesCSR()
        h = scipy.sparse.csr_matrix((value, column, start)) + (pad[0] if pad else 0)
        move[free] = scipy.sparse.linalg.spsolve(h[free][:, free].tocsc(), -gradient(x)[free] - (h @ move)[free])
        u.x.array[:] += move
        return np.abs(move).max()

    forces = []
    for at in np.array(body["at"]):
        u.x.array[:] = 0
        for step in range(1, body["steps"] + 1):
            for iteration in range(40):
                if step_to(at * step / body["steps"]) < 1e-13 * np.abs(u.x.array).max():
                    break
            else:
                sys.exit("Newton's method does not converge")
        forces.append(force(at).tolist())
    return forces


with open(sys.argv[1]) as bodies:
    forces = [solve(body) for body in json.load(bodies)]
with open(sys.argv[2], "w") as out:
    json.dump(forces, out)
