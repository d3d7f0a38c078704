"""Arrays that contradict what they are used for: masks, floats as numbers, masked and complex values, positions without
forces. Each fault is tried on ten variants of a seed. Usage: python_input.py COMMAND SCENE"""

import sys
import unittest

import numpy as np

import forefeel as ff

MODULUS = 1e4  # [Pa]


def block(rng):
    """A block cut into tetrahedra, its nodes in any order and turned; bottom and top as masks."""
    n, size = rng.integers(2, 4, 3), rng.uniform(0.02, 0.2, 3) * 10.0 ** rng.integers(-1, 2)
    grid = np.stack(np.meshgrid(*[np.arange(k + 1) for k in n], indexing="ij"), -1).reshape(-1, 3)
    node = {tuple(at): i for i, at in enumerate(grid)}
    tets = []
    for cell in np.ndindex(*n):
        for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
            path = [np.array(cell)]
            for axis in order:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            tet = [node[tuple(at)] for at in path]
            odd = order in ((0, 2, 1), (2, 1, 0), (1, 0, 2))
            tets.append([tet[0], tet[2], tet[1], tet[3]] if odd else tet)
    order = rng.permutation(len(grid))
    place = np.argsort(order)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    nodes = (grid / n * size)[order] @ turn.T
    return nodes, place[np.array(tets)], grid[order][:, 2] == 0, grid[order][:, 2] == n[2], size, turn


class Masks(unittest.TestCase):
    def test_a_mask_of_nodes_chooses_nodes_as_in_numpy(self):
        for seed in range(10):
            with self.subTest(seed=seed):
                nodes, tets, bottom, top, size, turn = block(np.random.default_rng(seed))
                press = 0.01 * size[2] * turn @ [0, 0, -1]
                exact = turn @ [0, 0, MODULUS * size[0] * size[1] * 0.01]  # E A u / L, at a Poisson's ratio of 0
                for clamp in (bottom, np.flatnonzero(bottom), bottom.tolist()):
                    for contact in (top, np.flatnonzero(top)):
                        body = ff.Body(nodes, tets, clamp, contact, "linear", MODULUS, 0.0)
                        self.assertTrue(np.array_equal(body.clamp, np.flatnonzero(bottom)))
                        self.assertTrue(np.array_equal(body.contact, np.flatnonzero(top)))
                # Sides are held by the clamp alone, so the exact solution is uniform.
                force = body.solve([press])["force"][0]
                self.assertLess(np.abs(force - exact).max(), 1e-8 * np.abs(exact).max())

    def test_other_masks_and_numbers_are_refused(self):
        for seed in range(10):
            rng = np.random.default_rng(seed)
            nodes, tets, bottom, top, _, _ = block(rng)
            clamp, contact = np.flatnonzero(bottom), np.flatnonzero(top)
            hidden = np.ma.array(clamp, mask=rng.permutation(len(clamp)) == 0)
            for arguments, words in (((nodes, tets, bottom[:-1], contact), "clamp: is a mask of the shape"),
                                     ((nodes, tets, clamp, np.append(top, True)), "contact: is a mask of the shape"),
                                     ((nodes, tets, np.zeros(len(nodes), bool), contact), "clamp: no node is in it"),
                                     ((nodes, tets + rng.uniform(0, 1), clamp, contact), "tets: has floats"),
                                     ((nodes, tets.astype(float), clamp, contact), "tets: has floats"),
                                     ((nodes, tets, clamp + 0.5, contact), "clamp: has floats"),
                                     ((nodes, tets, clamp, contact.astype(np.float32)), "contact: has floats"),
                                     ((nodes, tets + 0j, clamp, contact), "tets: has complex numbers"),
                                     ((nodes, tets, hidden, contact), "clamp: has masked values"),
                                     ((nodes, np.ma.array(tets, mask=tets == 3), clamp, contact), "tets: has masked"),
                                     ((np.ma.array(nodes, mask=rng.random(nodes.shape) < 0.1), tets, clamp, contact),
                                      "nodes: has masked"),
                                     ((nodes + 0j, tets, clamp, contact), "nodes: has complex numbers")):
                with self.subTest(seed=seed, words=words), self.assertRaisesRegex(ff.InputError, words):
                    ff.Body(*arguments)
        # Without masked values a masked array is an array.
        self.assertEqual(len(ff.Body(np.ma.array(nodes), tets, np.ma.array(clamp), contact).clamp), len(clamp))

    def test_masked_and_complex_values_are_refused_wherever_numbers_are_read(self):
        for seed in range(10):
            rng = np.random.default_rng(seed)
            states, points = rng.uniform(-0.03, 0.03, (60, 3)), rng.uniform(-0.03, 0.03, (5, 3))
            forces = -300 * states
            space = ff.StateSpace(ff.measured(states, forces), 0.006)
            for bad, words in ((np.ma.array(forces, mask=rng.random(forces.shape) < 0.2), "masked values"),
                               (list(np.ma.array(forces, mask=np.eye(60, 3) > 0)), "masked values"),
                               (forces + 1j * rng.normal(), "complex numbers"), ((forces + 0j).tolist(), "complex"),
                               (forces > 0, "array of numbers")):
                for use in (lambda: ff.evaluate(states, bad, points), lambda: ff.evaluate(bad, forces, points),
                            lambda: ff.evaluate(states, forces, bad), lambda: ff.measured(states, bad),
                            lambda: ff.classify(bad, points, 0.006), lambda: space.label(bad),
                            lambda: space.evaluate(bad), lambda: ff.StateSpace(bad, 0.006),
                            lambda: ff.error_bar(states, bad, points)):
                    with self.assertRaisesRegex(ff.InputError, words):
                        use()
            rows = ff.measured(states, forces)
            with self.assertRaisesRegex(ff.InputError, "masked values"):
                ff.StateSpace(np.ma.array(rows, mask=rng.random(60) < 0.3), 0.006)


class PositionsAlone(unittest.TestCase):
    def test_a_space_of_positions_has_labels_but_no_forces(self):
        for seed in range(10):
            rng = np.random.default_rng(seed)
            scale = 10.0 ** rng.integers(-1, 3)
            positions = rng.uniform(-0.01, 0.01, (rng.integers(1, 200), 3)) * scale
            given = (positions, positions.tolist(), positions.astype(np.float32), np.asfortranarray(positions))[seed % 4]
            space = ff.StateSpace(given, 0.003 * scale)
            with self.subTest(seed=seed):
                for use in (space.evaluate, space.error_bar, lambda at: space.model_at(at[0]),
                            lambda at: space.evaluate(at, method="rbf", kernel="linear")):
                    with self.assertRaisesRegex(ff.InputError, "positions alone have no forces"):
                        use(positions[:1])
                self.assertTrue(np.isnan(space.states["force"]).all())
                self.assertEqual(space.label(positions[:1])[0], ff.classify(positions, positions[:1], 0.003 * scale)[0])
                self.assertEqual(space.distance(positions[:1])[0] < 1e-6 * scale, True)
                self.assertEqual(space.nearest(positions[:1])[0].shape, (1, 1))
                # With forces, even zero ones, the same space answers.
                measured = ff.StateSpace(ff.measured(positions, 0 * positions), 0.003 * scale)
                self.assertTrue((measured.evaluate(positions[:1]) == 0).all())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
