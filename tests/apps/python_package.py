"""Bodies, files, interruption, errors and documentation of the package forefeel.

Usage: python_package.py COMMAND SCENE
"""

import inspect
import os
import pathlib
import pkgutil
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import forefeel as ff

COMMAND, SCENE = sys.argv[1], sys.argv[2]
SHORT = ["--clock", "virtual", "--seconds", "0.3", "--cost", "constant:0.02", "--device", "path:circle,speed=0.04"]


def run(*arguments, code=0):
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


def field(x):  # [N]
    return -300 * np.asarray(x)


class Anywhere(unittest.TestCase):
    def test_a_linear_body_is_exact_at_every_site(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "any.toml"
            scene.write_text('[body]\nphantom = "beam"\nelements = 240\n[material]\nlaw = "linear"\nyoung = 5000.0\n'
                             'poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n')
            touched = ff.SurfaceField(scene)
            sites = touched.sites[:5]
            self.assertEqual(touched.sites.shape[1], 3)
            stiffness, normals = touched.stiffness(sites)
            x = -0.004 * normals
            there = touched.evaluate(sites, x)
            self.assertLess(np.abs(there.force + np.einsum("nij,nj->ni", stiffness, x)).max(), 1e-9)
            self.assertLess(np.abs(there.energy - 0.5 * np.einsum("ni,nij,nj->n", x, stiffness, x)).max(), 1e-12)
            self.assertTrue(there.trusted.all())
            solved = touched.solve(sites, x)
            self.assertLess(np.abs(solved["force"] - there.force).max(), 1e-6)
            self.assertTrue(np.array_equal(solved["site"], there.site))
            with self.assertRaisesRegex(ff.InputError, "clamped"):
                touched.evaluate([0, 0.01, 0.01], [[0, 0, -0.001]])
            with self.assertRaisesRegex(ff.InputError, "sites"):
                touched.evaluate(sites[:2], x)
            with self.assertRaisesRegex(ff.InputError, "anywhere"):
                ff.SurfaceField(SCENE)
            run("generate", scene, "-o", f"{folder}/any.states")
            known = ff.read_states(f"{folder}/any.states")
            self.assertTrue(np.isfinite(known["site"]).all())
            again = ff.SurfaceField(scene, states=f"{folder}/any.states").evaluate(sites, x)
            self.assertLess(np.abs(again.force - there.force).max(), 1e-9)


class Bodies(unittest.TestCase):
    def test_a_body_made_of_arrays_gives_the_states_of_its_scene(self):
        scene = ff.Scene(SCENE)
        mesh = scene.body
        body = ff.Body(mesh.nodes, mesh.tets, mesh.clamp, mesh.contact, young=5000, poisson=0.3)
        at = [[0.002, 0, -0.003], [0, 0.004, 0]]
        ours, theirs = ff.solve(body, at), ff.solve(scene, at)
        self.assertTrue(np.array_equal(ours["force"], scene._scene._body().solve(at, 0.006, False, None)["force"]))
        self.assertLess(np.abs(ours["force"] - theirs["force"]).max(), 1e-6)
        states, moved = body.solve(at, displacements=True)
        self.assertEqual(moved.shape, (2, len(mesh.nodes), 3))
        self.assertTrue(np.array_equal(moved[0][mesh.contact], np.tile(at[0], (len(mesh.contact), 1))))
        self.assertTrue(np.array_equal(moved[0][mesh.clamp], np.zeros((len(mesh.clamp), 3))))
        states, moved, jets = body.solve(at, displacements=True, jet=3)
        self.assertEqual(moved.shape, (2, len(mesh.nodes), 3))
        self.assertEqual(list(jets[0])[:2] + list(jets[1])[-2:], ["e300", "e210", "e004", "limit"])
        self.assertEqual(len(jets[0]), 26)
        # E(x + d) of the jet against the energy there.
        d = np.array([1e-4, -2e-4, 1e-4])
        there = body.solve(at[0] + d)[0]
        energy = states["energy"][0] - states["force"][0] @ d + d @ states["stiffness"][0] @ d / 2
        third = sum(v * d[0] ** int(k[1]) * d[1] ** int(k[2]) * d[2] ** int(k[3])
                    for k, v in jets[0].items() if k.startswith("e"))
        self.assertLess(abs(energy + third - there["energy"]), 0.05 * abs(energy - there["energy"]))
        self.assertEqual(len(ff.solve(scene, at, jet=4)[1][0]), 47)
        with self.assertRaisesRegex(ff.InputError, "jet: is 5, expected 1 to 4"):
            body.solve(at, jet=5)
        lattice = ff.generate(body, 0.004, scene.box)
        self.assertTrue(np.array_equal(lattice["force"], scene.generate()["force"]))
        self.assertEqual(len(lattice), 27)

    def test_wrong_bodies_are_refused(self):
        nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
        for arguments, words in (((nodes, [[0, 1, 2, 4]], [0], [3]), "tets: row 0"),
                                 ((nodes, [[0, 1, 2, 3]], [7], [3]), "clamp: holds node 7"),
                                 ((nodes, [[0, 1, 2, 3]], [], [3]), "clamp"),
                                 ((nodes, [[0, 1, 2]], [0], [3]), r"tets: expected the shape \(t, 4\)")):
            with self.assertRaisesRegex(ff.InputError, words):
                ff.Body(*arguments)
        with self.assertRaisesRegex(ff.InputError, "law: is 'rubber', expected linear"):
            ff.Body(nodes, [[0, 1, 2, 3]], [0, 1, 2], [3], law="rubber")

    def test_progress_of_a_lattice_ends_at_one(self):
        seen = []
        ff.Scene(SCENE).generate(progress=seen.append)
        self.assertEqual(seen[-1], 1)
        self.assertEqual(seen, sorted(seen))

    def test_ctrl_c_ends_long_calls_and_is_python_s_again_after_a_command(self):
        scene = ff.Scene(SCENE)
        calls = (lambda: scene.generate(spacing=0.0002),
                 lambda: scene.session(clock="virtual", seconds=3600, device="path:circle,speed=0.04",
                                       cost="constant:0.02"),
                 lambda: scene.solve(np.random.default_rng(1).uniform(-0.004, 0.004, (20000, 3))))
        run("generate", SCENE, "-o", "c.states")
        ff.command("session", SCENE, *SHORT, "-o", "c", "--quiet")
        self.assertEqual(signal.getsignal(signal.SIGINT), signal.default_int_handler)
        for call in calls:
            timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            with self.assertRaises(KeyboardInterrupt):
                call()
            timer.join()


class Files(unittest.TestCase):
    def test_every_written_file_is_read(self):
        at = np.random.default_rng(1).uniform(-0.01, 0.01, (60, 3))
        states = ff.measured(at, field(at))
        ff.write_states("m.states", states, 0.004)
        run("export", "m.states", "-o", "m.csv")
        run("classify", "m.states", "-o", "c.vtu")
        run("classify", "m.states", "-o", "regions.csv")
        run("classify", "m.states", "--grid", "0.01", "-o", "grid.csv")
        run("mesh", "--phantom", "beam", "-o", "beam.msh", "--elements", "240")
        run("session", SCENE, *SHORT, "-o", "run")
        table = ff.read("m.csv")
        self.assertTrue(np.array_equal(table["fx"], states["force"][:, 0]))
        self.assertEqual(ff.read("m.states")["at"].tolist(), at.tolist())
        self.assertEqual(set(ff.read("grid.csv")["label"]) - set(ff.label_names), set())
        mesh = ff.read("beam.msh")
        self.assertEqual(mesh["tets"].shape[1], 4)
        self.assertLess(mesh["tets"].max(), len(mesh["nodes"]))
        grid = ff.read("c.vtu")
        self.assertEqual(len(grid["cells"]), len(grid["types"]))
        self.assertLess(grid["cells"].max(), len(grid["points"]))
        self.assertTrue(all(len(values) == len(grid["cells"]) for values in grid["cell_data"].values()))
        names = np.array(ff.label_names)[grid["cell_data"]["label"].astype(int)]
        self.assertEqual(grid["cell_data"]["label_name"].tolist(), names.tolist())
        cells = ff.read("c_cells.vtu")
        self.assertEqual(cells["cells"].shape[1], 4)
        points = ff.read("c_states.vtu")
        self.assertEqual(sorted(map(tuple, points["points"])), sorted(map(tuple, at)))
        self.assertEqual(points["point_data"]["force"].shape, (60, 3))
        run_files = ff.read("run")
        self.assertEqual(len(run_files["frames"]["t"]), 300)
        self.assertEqual(run_files["summary"]["frames"], 300)
        self.assertGreater(len(ff.read("run/session.states")), 0)
        self.check_all_of("run")

    def check_all_of(self, folder):
        """Reads every file below a folder; pictures, pages and the command's own marks (no ending) are left out."""
        seen = set()
        for file in pathlib.Path(folder).rglob("*"):
            if file.is_file() and file.suffix not in (".html", ".svg", ".png", ".pdf", ""):
                self.assertIsNotNone(ff.read(file), file)
                seen.add(file.suffix)
        return seen

    def test_the_inputs_of_a_run_are_those_of_its_frames(self):
        run("session", SCENE, *SHORT, "-o", "kept")
        inputs, table = ff.read("kept/session.inputs"), ff.read_run("kept")
        frames = inputs["frames"]
        self.assertTrue(inputs["whole"])
        self.assertEqual((inputs["clock"], inputs["frame_seconds"], inputs["frames_planned"]), ("virtual", 0.001, 300))
        self.assertEqual(frames["frame"].tolist(), list(range(300)))
        for field, columns in (("at", "x y z"), ("sent", "fx fy fz")):
            written = np.stack([table["frames"][name] for name in columns.split()], axis=1)
            self.assertTrue(np.array_equal(frames[field], written), field)
        self.assertEqual(len(inputs["states"]), len(table["states"]))
        self.assertEqual(sorted(map(tuple, inputs["states"]["at"])), sorted(map(tuple, table["states"]["at"])))
        self.assertEqual(len(inputs["failed"]), 0)
        self.assertGreater(inputs["models"]["published"].sum(), 0)
        self.assertEqual(inputs["box"].tolist(), ff.Scene(SCENE).box.tolist())
        whole = pathlib.Path("kept/session.inputs").read_bytes()
        pathlib.Path("cut.inputs").write_bytes(whole[:len(whole) * 2 // 3])
        cut = ff.read("cut.inputs")
        self.assertFalse(cut["whole"])
        self.assertTrue(0 < len(cut["frames"]) < 300)
        pathlib.Path("other.inputs").write_text("something else")
        with self.assertRaisesRegex(ff.InputError, "other.inputs"):
            ff.read("other.inputs")

    def test_every_file_of_each_kind_of_folder_is_read(self):
        pathlib.Path("s.toml").write_text(f"""scene = "{SCENE}"
seeds = [1]
[session]
seconds = 0.2
cost = "constant:0.02"
[vary]
policy = ["nearest", "coverage"]
""")
        run("study", "s.toml", "-o", "s", "--quiet")
        run("study", "s.toml", "-o", "s", "--gantt", "1", "--quiet")
        self.assertEqual(self.check_all_of("s"), {".csv", ".json"})
        self.assertEqual(len(ff.read("s")["cells"]["policy"]), 2)
        run("session", SCENE, *SHORT, "--shape-rate", "20", "-o", "shaped")
        self.assertEqual(self.check_all_of("shaped"), {".csv", ".json", ".states", ".inputs", ".pvd", ".vtu"})
        pathlib.Path("series").mkdir()
        run("classify", "shaped", "-o", "series/coverage.pvd")
        self.assertLessEqual({".pvd", ".vtu"}, self.check_all_of("series"))
        pathlib.Path("empty").mkdir()
        with self.assertRaisesRegex(ff.InputError, "empty: expected a folder"):
            ff.read("empty")
        self.assertEqual(ff.read(SCENE)["state_space"]["spacing"], ff.Scene(SCENE).spacing)

    def test_a_frame_without_pandas_is_a_structured_array(self):
        states = ff.States(ff.measured([[0, 0, 0.001]], [[1, 2, 3]]), 0.01, None, {}, {})
        kept = sys.modules.get("pandas")
        sys.modules["pandas"] = None
        try:
            table = states.to_frame()
        finally:
            if kept is None:
                del sys.modules["pandas"]
            else:
                sys.modules["pandas"] = kept
        self.assertEqual(table["fy"][0], 2)
        self.assertEqual(table["status"][0], "measured")

    def test_errors_are_the_command_s_own_line(self):
        pathlib.Path("broken.csv").write_text("x,y,z,fx,fy,fz\n0,0,0,1,2,oops\n")
        pathlib.Path("wrong.toml").write_text("[boddy]\nphantom = 'beam'\n")
        for words, call in ((("info", "broken.csv"), lambda: ff.read_states("broken.csv")),
                            (("solve", "wrong.toml", "--at=0,0,0"), lambda: ff.Scene("wrong.toml")),
                            (("solve", "none.toml", "--at=0,0,0"), lambda: ff.Scene("none.toml")),
                            (("classify", "broken.csv"), lambda: ff.command("classify", "broken.csv"))):
            said = run(*words, code=2).stderr
            with self.assertRaises(ff.InputError) as raised:
                call()
            self.assertEqual(said, f"forefeel: {raised.exception}\n")
        with self.assertRaisesRegex(ff.InputError, "nothing.vtu: cannot be read"):
            ff.read("nothing.vtu")
        with self.assertRaisesRegex(ff.InputError, "has the ending '.doc'"):
            ff.read("a.doc")


    def test_wrong_arguments_are_one_line(self):
        scene = ff.Scene(SCENE)
        for call, line in (
                (lambda: ff.classify([[0, 0, 0]], [["a", 0, 0]]), "points: expected an array of numbers"),
                (lambda: ff.classify([[0, 0, 0]], [[0, 0, 0]], spacing="wide"), "spacing: is 'wide', expected metres"),
                (lambda: ff.StateSpace([[0, 0, 0]], 0.01).nearest([0, 0, 0], 0), "n: is 0, expected a whole number >= 1"),
                (lambda: ff.StateSpace(np.zeros(3, [("x", float)])), "states: has other fields than state_dtype; "
                 "forefeel.measured() makes such an array"),
                (lambda: ff.evaluate([[0, 0, 0]], [[0, 0, 1]], [[0, 0, 0]], neighbours="many"),
                 "neighbours: is 'many', expected a whole number"),
                (lambda: scene.session(workers=2.5), "workers: is 2.5, expected a whole number"),
                (lambda: scene.session(seconds="long"), "seconds: is 'long', expected a number"),
                (lambda: scene.solve([[0, 0, 0], [0, 0, 1e9]]), "positions: row 1 (from 0) is farther from rest than 10 "
                 "m, 100 times the body's longest side; expected metres"),
                (lambda: ff.Placement([0, 0], [1, 1], 0.1),
                 "Placement: expected corners (3,) with low < high, and spacing > 0")):
            with self.assertRaises(ff.InputError) as raised:
                call()
            self.assertEqual(str(raised.exception), line)


class Vectorised(unittest.TestCase):
    def test_models_equal_one_call_for_each_point(self):
        at = np.random.default_rng(2).uniform(-0.01, 0.01, (200, 3))
        space = ff.StateSpace(ff.measured(at, field(at)), spacing=0.004)
        model = space.model_at([0, 0, 0], kernel="cubic", neighbours=40)
        points = np.random.default_rng(3).uniform(-0.01, 0.01, (500, 3))
        self.assertTrue(np.array_equal(model.force(points), np.concatenate([model.force(q) for q in points])))
        slopes = model.jacobian(points[:20])
        step = 1e-6
        for j, e in enumerate(np.eye(3)):
            numeric = (model.force(points[:20] + step * e) - model.force(points[:20] - step * e)) / (2 * step)
            self.assertLess(np.abs(slopes[:, :, j] - numeric).max(), 1e-3 * np.abs(slopes).max())
        rows, distances = space.nearest(points, 3)
        known = np.linalg.norm(points[:, None] - at[rows], axis=2)
        self.assertTrue(np.allclose(known, distances, rtol=1e-14))
        self.assertEqual(set(model.states) - set(range(200)), set())
        self.assertTrue(np.allclose(np.sort(np.linalg.norm(at[model.states], axis=1)),
                                    np.sort(np.linalg.norm(at, axis=1))[:40]) or len(model.states) == 40)

    def test_error_bars_hold_the_truth_and_are_those_of_single_points(self):
        random = np.random.default_rng(5)
        at = random.uniform(-0.01, 0.01, (400, 3))

        def truth(x):
            return -300 * x - 2 * np.sin(400 * x)

        points = random.uniform(-0.009, 0.009, (600, 3))
        options = {"method": "rbf", "kernel": "cubic", "neighbours": 40}
        space = ff.StateSpace(ff.measured(at, truth(at)), spacing=0.003)
        error = np.linalg.norm(space.evaluate(points, **options) - truth(points), axis=1)
        inside = [(error <= space.error_bar(points, level, **options)).mean() for level in (0.9, 0.95, 0.99)]
        self.assertTrue(0.85 < inside[0] <= inside[1] <= inside[2], inside)
        model = space.model_at([0, 0, 0], kernel="cubic", neighbours=40)
        bars = model.error_bar(points, 0.9)
        self.assertTrue(np.array_equal(bars[:20], np.concatenate([model.error_bar(q, 0.9) for q in points[:20]])))
        self.assertTrue((bars <= model.error_bar(points, 0.99)).all())
        near = np.linalg.norm(points, axis=1) < 0.004
        error = np.linalg.norm(model.force(points[near]) - truth(points[near]), axis=1)
        self.assertGreater((error <= bars[near]).mean(), 0.8)
        for call in (lambda: model.error_bar(points, 0.5), lambda: space.error_bar(points, level=0.5)):
            with self.assertRaisesRegex(ff.InputError, "level: is 0.5, expected 0.9, 0.95"):
                call()
        with self.assertRaisesRegex(ff.InputError, "which has no error bars"):
            space.error_bar(points[:3], method="offline-rbf")

    def test_built_in_priorities_are_those_of_the_built_in_policy(self):
        checked = []

        class Same:
            def prioritise(self, candidates, view):
                near = view.spacing / (view.spacing + np.linalg.norm(candidates["at"] - view.hip, axis=1))
                checked.append(np.allclose(view.prioritise("nearest", candidates), near ** 2, rtol=1e-14))
                return near

        ff.Scene(SCENE).session(policy=Same(), clock="virtual", seconds=0.2, cost="constant:0.02")
        self.assertTrue(checked and all(checked))

    def test_a_rule_of_one_s_own_places_states(self):
        class Far:
            def doubt(self, states, candidates):
                return np.linalg.norm(candidates, axis=1)

        placement = ff.Placement([-0.02] * 3, [0.02] * 3, 0.01, rule=Far())
        for x in placement.ask(9):
            placement.tell(x, field(x))
        x = placement.ask(1)[0]
        left = [c for c in placement.candidates if not (placement.states["at"] == c).all(axis=1).any()]
        self.assertAlmostEqual(np.linalg.norm(x), max(np.linalg.norm(left, axis=1)))


class Versions(unittest.TestCase):
    def test_another_version_of_python_is_told_the_one_that_the_module_was_built_for(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "forefeel"
            shutil.copytree(pathlib.Path(ff.__file__).parent, package, ignore=shutil.ignore_patterns("_core.*.so"))
            (package / "_core.cpython-399-x86_64-linux-gnu.so").touch()
            done = subprocess.run([sys.executable, "-c", "import forefeel"], capture_output=True, text=True,
                                  env={**os.environ, "PYTHONPATH": folder})
        self.assertNotEqual(done.returncode, 0)
        this = f"{sys.version_info[0]}.{sys.version_info[1]}"
        self.assertIn(f"ImportError: forefeel was built for Python 3.99, this is Python {this}", done.stderr)


class Documentation(unittest.TestCase):
    def test_all_that_is_public_says_what_it_is(self):
        for module in pkgutil.iter_modules(ff.__path__):
            self.assertTrue(getattr(ff, module.name, None) is None or inspect.getdoc(getattr(ff, module.name)))
        for name in ff.__all__:
            thing = getattr(ff, name)
            if not (inspect.isclass(thing) or callable(thing)):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            if inspect.isclass(thing) and thing is not ff.InputError:
                for attribute, member in vars(thing).items():
                    if not attribute.startswith("_") and attribute not in ("file", "warnings", "keys"):
                        if callable(member) or isinstance(member, (property, classmethod)):
                            self.assertTrue(inspect.getdoc(member), f"{name}.{attribute}")

    def test_no_documentation_shows_a_type_of_cpp(self):
        def texts(thing, name):
            yield name, thing.__doc__ or ""
            if isinstance(thing, property):
                yield name, thing.fget.__doc__ or ""
            if inspect.isclass(thing):
                for attribute, member in vars(thing).items():
                    if attribute == "__init__" or not attribute.startswith("_"):
                        yield from texts(member, f"{name}.{attribute}")

        checked = 0
        for name, thing in vars(ff._core).items():
            for where, text in texts(thing, name):
                self.assertNotRegex(text, "::| object at 0x", where)
                checked += "->" in text
        self.assertGreater(checked, 30)

    def test_functions_have_types(self):
        for name in ff.__all__:
            thing = getattr(ff, name)
            if inspect.isfunction(thing):
                self.assertIn("return", thing.__annotations__, name)
                self.assertEqual(set(inspect.signature(thing).parameters) - set(thing.__annotations__), set(), name)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
