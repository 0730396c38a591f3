"""The notebooks: each runs as a program, and its own assertions hold."""

import os
import subprocess
import sys
import tempfile
import unittest

import support

FOLDER = os.path.join(support.SOURCE, "runtime", "apps", "python", "notebooks")


class Notebooks(unittest.TestCase):
    def run_notebook(self, name, pictures):
        kept = os.environ.get("TREMOLO_PICTURES")
        with tempfile.TemporaryDirectory() as folder:
            place = kept or folder
            environment = {**os.environ, "MPLBACKEND": "Agg", "MPLCONFIGDIR": folder}
            done = subprocess.run([sys.executable, os.path.join(FOLDER, name + ".py")], cwd=place, env=environment,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout)
            for picture in pictures:
                self.assertGreater(os.path.getsize(os.path.join(place, picture)), 5000)

    def test_a_mesh_of_numpy_becomes_a_vibrating_body(self):
        self.run_notebook("vibrating_body", ["vibrating_body_modes.png", "vibrating_body_motion.png"])

    def test_integrators_have_their_order(self):
        self.run_notebook("integrators", ["integrators.png"])

    def test_a_potential_in_python_recurs(self):
        self.run_notebook("own_potential", ["own_potential.png"])

    def test_a_gripper_lifts_a_ball(self):
        self.run_notebook("gripper", ["gripper_control.png", "gripper_end.png"])

    def test_a_clamped_beam_answers_as_its_formula(self):
        self.run_notebook("response", ["response.png"])

    def test_the_modulus_of_a_bell_is_found(self):
        self.run_notebook("bell", ["bell.png"])

    def test_all_are_run_here(self):
        files = {name[:-3] for name in os.listdir(FOLDER) if name.endswith(".py")}
        self.assertEqual(files, {"vibrating_body", "integrators", "response", "bell", "own_potential", "gripper"})


if __name__ == "__main__":
    unittest.main()
