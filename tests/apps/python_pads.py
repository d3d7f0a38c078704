"""Bodies of the package forefeel that are touched through a pad. Usage: python_pads.py COMMAND SCENE"""

import json
import pathlib
import subprocess
import sys
import unittest

import numpy as np

import forefeel as ff

COMMAND, SCENE = sys.argv[1], sys.argv[2]


def solved(scene, at):
    places = ["--at=" + ",".join(map(str, x)) for x in at]
    done = subprocess.run([COMMAND, "solve", scene, *places, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["states"]


class Pads(unittest.TestCase):
    def test_a_body_with_a_pad_gives_the_forces_of_the_command(self):
        pathlib.Path("pad.toml").write_text(pathlib.Path(SCENE).read_text() + """[contact]
pad = 700.0
radius = 0.012
nearest = [0.071, 0.011, 0.03]
""")
        at = [[0.002, -0.001, -0.004], [0, 0.003, 0.002]]
        said = solved("pad.toml", at)
        scene = ff.Scene("pad.toml")
        mesh = scene.body
        pad = {"nearest": (0.071, 0.011, 0.03), "radius": 0.012, "stiffness": 700}
        body = ff.Body(mesh.nodes, mesh.tets, mesh.clamp, young=5000, poisson=0.3, pad=pad)
        states = body.solve(at, spacing=scene.spacing)
        self.assertEqual(states["force"].tolist(), [state["force"] for state in said])
        self.assertEqual(states["energy"].tolist(), [state["energy"] for state in said])
        self.assertEqual(len(body.contact), 0)
        self.assertLess(np.abs(body.pad["nearest"] - [0.071, 0.011, 0.02]).max(), 1e-12)  # the upper side
        self.assertEqual((body.pad["radius"], body.pad["stiffness"]), (0.012, 700))
        again = ff.Body(mesh.nodes, mesh.tets, mesh.clamp, [], young=5000, poisson=0.3, pad=mesh.pad)
        self.assertLess(np.abs(again.solve(at, spacing=scene.spacing)["force"] - states["force"]).max(), 1e-9)
        usual = ff.Body(mesh.nodes, mesh.tets, mesh.clamp, pad={"nearest": pad["nearest"]})
        self.assertEqual((usual.pad["radius"], usual.pad["stiffness"]), (0.02, 1000))
        self.assertIsNone(ff.Scene(SCENE).body.pad)

    def test_wrong_pads_are_refused(self):
        mesh = ff.Scene(SCENE).body
        top = (0.071, 0.011, 0.03)

        def refused(pad, words, contact=()):
            with self.assertRaisesRegex(ff.InputError, words):
                ff.Body(mesh.nodes, mesh.tets, mesh.clamp, contact, pad=pad)

        refused({"nearest": top}, "^contact: names nodes beside pad", mesh.contact)
        refused(700, "^pad: is 700, expected a dict with nearest, radius, stiffness")
        refused({}, "^pad.nearest: missing")
        refused({"nearest": top, "width": 0.02}, "^pad: has 'width', expected nearest, radius, stiffness")
        refused({"nearest": "tip"}, "^pad.nearest: is 'tip', expected three numbers")
        refused({"nearest": (0.07, 0.01)}, r"^pad.nearest: is \(0.07, 0.01\), expected three numbers")
        refused({"nearest": (0.07, np.nan, 0)}, "^pad.nearest: ")
        refused({"nearest": (71, 11, 30)}, "^pad.nearest: is far from the body")
        refused({"nearest": top, "radius": 0}, "^pad.radius: is 0 m, expected a number above 0")
        refused({"nearest": top, "radius": "wide"}, "^pad.radius: is 'wide', expected a number")
        refused({"nearest": top, "stiffness": np.inf}, "^pad.stiffness: is inf N/m, expected a number above 0")
        held = mesh.nodes[mesh.clamp].mean(axis=0)
        refused({"nearest": held, "radius": 0.001}, "all nodes under the pad are clamped")
        refused(None, "contact: no node is in it")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
