"""Checks the package forefeel against the command and against SciPy. Usage: python_module.py COMMAND SCENE"""

import csv
import json
import subprocess
import sys
import unittest

import numpy as np

import forefeel as ff

COMMAND, SCENE = sys.argv[1], sys.argv[2]


def run(*arguments):
    done = subprocess.run([COMMAND, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def save(file, header, *columns):
    with open(file, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header.split(","))
        writer.writerows([[repr(float(v)) for v in row] for row in np.column_stack(columns)])


def cloud(n, seed):
    return np.random.default_rng(seed).uniform(-0.03, 0.03, (n, 3))


def field(x):  # a stiffening field [N]
    x = np.asarray(x)
    return -300 * x - 2e5 * x * (x ** 2).sum(axis=-1, keepdims=True)


def stiffness(x):  # K = -df/dx [N/m]
    return 300 * np.eye(3) + 2e5 * (x @ x * np.eye(3) + 2 * np.outer(x, x))


class LikeTheCommand(unittest.TestCase):
    def test_classify(self):
        states, points = cloud(400, 1), cloud(500, 2) * 2
        save("states.csv", "x,y,z,fx,fy,fz", states, field(states))
        save("points.csv", "x,y,z", points)
        said = json.loads(run("classify", "states.csv", "--points", "points.csv", "--spacing", "0.006", "--json"))
        labels = ff.classify(states, points, spacing=0.006)
        self.assertEqual(labels.dtype, np.uint8)
        self.assertEqual([ff.label_names[k] for k in labels], said["labels"])
        space = ff.StateSpace(states, spacing=0.006)
        self.assertEqual(space.label(points).tolist(), labels.tolist())
        known = np.array([np.inf if v is None else v for v in said["spread"]])
        self.assertTrue(np.array_equal(space.spread(points), known))
        self.assertTrue(np.array_equal(space.distance(points), np.array(said["delta"])))
        far = ff.StateSpace([[0, 0, 0], [1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4], [1, 1, 1]], spacing=1e-4)
        with self.assertRaisesRegex(ff.InputError, "expected at most 1e9"):
            far.coverage()
        cover = space.coverage()
        self.assertEqual(cover.volume.tolist(), [said["volume"][name] for name in ff.label_names])
        for number, name in enumerate(ff.label_names):
            parts = cover.components[cover.components["label"] == number]
            self.assertEqual(len(parts), said["components"][name])
            self.assertAlmostEqual(parts["volume"].sum(), said["volume"][name], delta=1e-12)
        hole = cover.holes[0]
        self.assertAlmostEqual(hole["radius"], said["largest_hole"]["radius"], delta=1e-9)
        self.assertTrue(np.allclose([hole["x"], hole["y"], hole["z"]], said["largest_hole"]["centre"], atol=1e-9))
        self.assertTrue((np.diff(cover.holes["radius"]) <= 0).all())
        at = np.stack([cover.holes[axis] for axis in "xyz"], axis=1)
        nearest = np.linalg.norm(at[:, None] - states[None], axis=2).min(axis=1)
        self.assertTrue(np.allclose(nearest, cover.holes["radius"], atol=1e-9))    # empty, and touched by a state

    def test_evaluate(self):
        states, points = cloud(300, 3), cloud(100, 4)
        save("f.csv", "x,y,z,fx,fy,fz", states, field(states))
        save("q.csv", "x,y,z", points)
        for options in ({"kernel": "cubic", "neighbours": 60}, {"kernel": "linear", "neighbours": 30, "ridge": 0.01},
                        {"kernel": "quintic", "neighbours": 50, "select": "nearest"}, {"method": "offline-rbf"}):
            flags = [text for key, value in options.items() for text in ("--" + key, str(value))]
            if "method" not in options:
                flags += ["--method", "rbf"]
            said = json.loads(run("evaluate", "f.csv", "--points", "q.csv", "--json", *flags))
            forces = ff.evaluate(states, field(states), points, **{"method": "rbf", **options})
            self.assertTrue(np.array_equal(forces, np.array(said["forces"])), options)

    def test_error_bars(self):
        states, points = cloud(300, 3), cloud(100, 4)
        save("f.csv", "x,y,z,fx,fy,fz", states, field(states))
        save("q.csv", "x,y,z", points)
        for options in ({"method": "rbf", "kernel": "cubic", "neighbours": 60}, {}):
            flags = [text for key, value in options.items() for text in ("--" + key, str(value))]
            said = json.loads(run("evaluate", "f.csv", "--points", "q.csv", "--json", *flags))
            for level in (90, 95, 99):
                bars = ff.error_bar(states, field(states), points, level=level / 100, **options)
                known = np.array([np.inf if v is None else v for v in said[f"bar{level}"]])
                self.assertTrue(np.array_equal(bars, known), (level, options))
            used = ff.evaluation(states, field(states), points, bars=True, **options)[1]
            self.assertEqual(used["error_bar"]["samples"], said["error_bar"]["samples"])
            self.assertEqual(used["error_bar"]["width_p50"], said["error_bar"]["width_p50"])

    def test_chosen_model(self):
        states, points = cloud(120, 8), cloud(30, 9)
        noisy = field(states) + np.random.default_rng(10).normal(0, 0.05, states.shape)
        save("n.csv", "x,y,z,fx,fy,fz", states, noisy)
        save("q.csv", "x,y,z", points)
        said = json.loads(run("evaluate", "n.csv", "--points", "q.csv", "--json"))
        forces, used = ff.evaluation(states, noisy, points)
        self.assertTrue(np.array_equal(forces, np.array(said["forces"])))
        self.assertEqual(used["kernel"], said["chosen"]["kernel"])
        self.assertEqual(used["expected_error"]["p95"], said["expected_error"]["p95"])

    def test_a_single_position_has_no_spacing(self):
        with self.assertRaisesRegex(ff.InputError, "spacing: is not given"):
            ff.classify([[0, 0, 0.001]] * 3, [[0, 0, 0]])
        self.assertEqual(len(ff.classify([[0, 0, 0.001]], [[0, 0, 0]], spacing=0.006)), 1)

    def test_states_and_solves(self):
        scene = ff.Scene(SCENE)
        states = scene.generate()
        for positions in (states.array["at"][:4], [[0.001, 0.002, 0.003]], [0.001, 0.002]):
            with self.assertRaisesRegex(ff.InputError, "positions alone have no forces"):
                scene.session(clock="virtual", seconds=0.1, states=positions)
            with self.assertRaisesRegex(ff.InputError, "positions alone have no forces"):
                ff.write_states("none.states", positions, 0.004)
        ff.write_states("lattice.states", states, scene.spacing)
        again = ff.read_states("lattice.states")
        self.assertEqual(len(again), len(states))
        for field in ("at", "force", "stiffness", "energy", "status"):
            self.assertTrue(np.array_equal(again.array[field], states.array[field], equal_nan=True), field)
        at = states.array["at"][-1]
        said = json.loads(run("solve", SCENE, "--at=" + ",".join(map(repr, at.tolist())), "--json"))
        one = scene.solve(at)
        self.assertEqual(one["force"][0].tolist(), said["states"][0]["force"])

    def test_session(self):
        flags = ["--clock", "virtual", "--seconds", "0.5", "--policy", "nearest", "--cost", "constant:0.02",
                 "--device", "path:circle,speed=0.04"]
        run("session", SCENE, *flags, "-o", "run")
        table = ff.read_run("run")
        made = ff.Scene(SCENE).session(clock="virtual", seconds=0.5, policy="nearest", cost="constant:0.02",
                                       device="path:circle,speed=0.04")
        for name in ("frames", "dispatches", "switches"):
            array, file = getattr(made, name), table[name]
            fields = {field: columns.split(",") for field, columns, _, _ in made.fields[name]}
            self.assertEqual(sum(fields.values(), []), list(array.dtype.names))
            self.assertLessEqual(set(file), set(array.dtype.names))
            for field, columns in fields.items():
                if columns[0] not in file:
                    continue
                values = array[field].reshape(len(array), -1).T
                for value, column in zip(values, columns):
                    written = np.asarray(file[column])
                    if array[field].dtype == np.uint8:   # a word
                        pairs = set(zip(value.tolist(), written.astype(str).tolist()))
                        self.assertEqual(len(pairs), len(set(value.tolist())), field)
                    else:
                        self.assertTrue(np.array_equal(value, written.astype(float), equal_nan=True), field)
        self.assertEqual([ff.label_names[k] for k in made.frames["label"]], list(table["frames"]["label"]))
        one, other = made.summary, dict(table["summary"])
        for summary in (one, other):
            for key in ("wall_seconds", "memory_locked"):
                summary.pop(key)
            summary["provenance"].pop("command")
        self.assertEqual(list(one), list(other))
        self.assertEqual(one, other)
        self.assertGreater(one["discretisation_error"], 0)
        self.assertEqual(len(made.dispatches), len(table["dispatches"]["id"]))

    def test_states_of_a_file_foreign_or_extended(self):
        scene, short = ff.Scene(SCENE), {"clock": "virtual", "seconds": 0.2, "cost": "constant:0.02"}
        first = scene.session(**short)
        scene.session(states="grown.states", extend=True, **short)
        self.assertEqual(len(ff.read_states("grown.states")), len(first.states))
        known = scene.generate()
        foreign = scene.session(states=known, foreign=True, **short)
        self.assertTrue(foreign.summary["states"]["foreign"])
        self.assertEqual(foreign.summary["states"]["solved"], 0)
        for wrong in ({"foreign": True}, {"extend": True, "states": known}):
            with self.assertRaises(ff.InputError):
                scene.session(**short, **wrong)


class Nearest:
    """The built-in policy's rule is not used; this one is nearest to where the HIP will be."""

    def __init__(self):
        self.calls = 0

    def prioritise(self, candidates, view):
        self.calls += 1
        ahead = view.predicted["at"][len(view.predicted) // 2]
        return view.spacing / (view.spacing + np.linalg.norm(candidates["at"] - ahead, axis=1))


class Written(unittest.TestCase):
    OPTIONS = dict(clock="virtual", seconds=0.5, cost="constant:0.02")

    def test_policy_repeats(self):
        scene = ff.Scene(SCENE)
        runs = [scene.session(policy=Nearest(), device="path:circle,speed=0.04", **self.OPTIONS) for _ in range(2)]
        self.assertGreater(len(runs[0].dispatches), 5)
        self.assertEqual(runs[0].frames.tobytes(), runs[1].frames.tobytes())
        self.assertEqual(runs[0].dispatches.tobytes(), runs[1].dispatches.tobytes())

    def test_policy_decides(self):
        class Corner:
            def prioritise(self, candidates, view):
                return 1 + candidates["at"].sum(axis=1) / np.abs(candidates["at"]).sum(axis=1).max()

        made = ff.Scene(SCENE).session(policy=Corner(), workers=1, **self.OPTIONS)
        first = made.dispatches["at"][1:6].sum(axis=1)  # the first is rest
        self.assertGreater(first.mean(), made.dispatches["at"].sum(axis=1).mean() + 0.001)

    def test_device_and_predictor(self):
        class Press:
            duration = 0.4

            def position(self, t, force):
                return (0, 0, -0.004 * np.sin(np.pi * t / 0.4) ** 2)

        class Still:
            def observe(self, t, at, velocity):
                self.at = at.copy()

            def predict(self, horizon):
                return self.at, 0.001

        made = ff.Scene(SCENE).session(device=Press(), predictor=Still(), clock="virtual", cost="constant:0.02")
        self.assertEqual(made.frames["t"][-1], 0.4)
        self.assertAlmostEqual(made.frames["at"][:, 2].min(), -0.004, delta=1e-4)

    def test_study_with_a_policy_of_ones_own(self):
        ff.register_policy("python-nearest", Nearest)
        with open("study.toml", "w") as out:
            out.write(f'''scene = "{SCENE}"
seeds = [1, 2]
[session]
seconds = 0.3
cost = "constant:0.02"
[vary]
policy = ["nearest", "python-nearest"]
''')
        result = ff.study("study.toml", "study")
        self.assertEqual(list(result["cells"]["policy"]), ["nearest"] * 2 + ["python-nearest"] * 2)
        self.assertTrue((result["cells"]["states.solved"] > 0).all())

    def test_study_with_a_predictor_of_ones_own(self):
        class Still:
            """The hand stays where it is."""

            def __init__(self, deviation="0.0002"):
                self.deviation = float(deviation)

            def observe(self, t, at, velocity):
                self.at = at.copy()

            def predict(self, horizon):
                return self.at, self.deviation

        class Wrong(Still):
            def predict(self, horizon):
                raise KeyError("mine")

        ff.register_predictor("python-still", Still)
        ff.register_predictor("python-wrong", Wrong)
        study = f'''scene = "{SCENE}"
seeds = [1]
[session]
seconds = 0.6
cost = "constant:0.02"
device = "path:line,speed=0.02,amplitude=0.02"
[vary]
"session.predictor" = '''
        with open("predictors.toml", "w") as out:
            out.write(study + '["kalman", "python-still", "python-still:deviation=0.1"]\n')
        cells = ff.study("predictors.toml", "predictors")["cells"]
        # At 20 mm/s, without a turn, the hand is 2 mm away after 0.1 s.
        far = np.asarray(cells["prediction.ms100.p95"], float)
        self.assertAlmostEqual(far[1], 0.002, delta=2e-4)
        self.assertLess(far[0], 0.5 * far[1])
        within = np.asarray(cells["prediction.ms100.within_50"], float)
        self.assertLess(within[1], 0.3)   # the ball of 50 % has 1.54 deviations, 0.3 mm
        self.assertEqual(within[2], 1)
        with open("wrong.toml", "w") as out:
            out.write(study + '["python-wrong"]\n')
        with self.assertRaisesRegex(RuntimeError, "predictor: KeyError"):
            ff.study("wrong.toml", "wrong")

    def test_errors_come_back(self):
        class Wrong:
            def prioritise(self, candidates, view):
                raise KeyError("mine")

        with self.assertRaises(KeyError):
            ff.Scene(SCENE).session(policy=Wrong(), **self.OPTIONS)

        class Negative:
            def prioritise(self, candidates, view):
                return -np.ones(len(candidates))

        with self.assertRaisesRegex(ff.InputError, "expected finite numbers"):
            ff.Scene(SCENE).session(policy=Negative(), **self.OPTIONS)
        with self.assertRaisesRegex(ff.InputError, r"shape \(5, 2\), expected \(n, 3\)"):
            ff.classify(np.zeros((5, 2)), np.zeros((1, 3)))
        with self.assertRaises(TypeError):
            ff.evaluate(cloud(5, 0), cloud(5, 0), cloud(1, 0), nosuch=1)
        with self.assertRaises(ff.InputError):
            ff.Scene("missing.toml")

    def test_ask_and_tell(self):
        placement = ff.Placement([-0.03] * 3, [0.03] * 3, 0.006)
        while len(placement) < 60:
            for x in placement.ask(4):
                placement.tell(x, field(x), stiffness(x))
        points = cloud(400, 5) * 0.9
        truth = field(points)
        told = placement.states
        self.assertEqual(len(np.unique(told["at"], axis=0)), len(told))
        ours = ff.evaluate(told["at"], told["force"], points, told["stiffness"])
        lattice = placement.candidates[np.random.default_rng(0).choice(len(placement.candidates), 60, replace=False)]
        drawn = ff.evaluate(lattice, field(lattice), points, np.array([stiffness(x) for x in lattice]))

        def error(forces):
            size = np.maximum(np.linalg.norm(truth, axis=1), placement.floor)
            return np.quantile(np.linalg.norm(forces - truth, axis=1) / size, 0.95)

        self.assertLess(error(ours), 0.7 * error(drawn))

    def test_smooth_like_scipy(self):
        from scipy.interpolate import RBFInterpolator
        states, points = cloud(200, 6), cloud(50, 7)
        theirs = RBFInterpolator(states, field(states), kernel="cubic", degree=1)(points)
        ours = ff.evaluate(states, field(states), points, method="offline-rbf", kernel="cubic")
        inside = ff.StateSpace(states, spacing=0.02).label(points) == ff.SAFE
        self.assertGreater(inside.sum(), 10)
        self.assertLess(np.abs(ours - theirs)[inside].max(), 1e-9)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
