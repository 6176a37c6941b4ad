"""Stubs of components, as mypy reads them."""

import os
import subprocess
import sys
import tempfile
import unittest

import genom
from genom import stubs

from .support import WATCHDOG, DemoCase

RIGHT = """
from typing import Dict, cast
import genom
from axis import Axis
axis = cast(Axis, genom.connect().load("axis"))
speed: float = axis.get_speed()["velocity"]
axis.set_speed()
axis.set_speed(velocity=0.5)
activity: genom.Activity = axis.goto(1.0, ack=True)
activity = axis.goto(goal=1, callback=lambda ended: print(ended.result))
state = axis.position.read()
if state is not None:
    where: float = state["position"]
axis.emergency()
try:
    axis.goto()
except axis.OUT_OF_RANGE as error:
    print(error.detail)
"""
WRONG = {
    'axis.goto("far")': "matches argument type",
    "axis.set_speed(velocty=1.0)": "Unexpected keyword",
    'axis.get_speed()["speed"]': "has no key",
    "axis.gotoo()": "has no attribute",
    'state["place"]': "has no key",
}


class Stubs(DemoCase):
    def load(self):
        axis = self.g.load(os.environ["GENOM_DEMO"], "-i", "axis")
        self.addCleanup(genom.Component.unload, axis)
        return axis

    def check(self, folder, text):
        script = os.path.join(folder, "script.py")
        with open(script, "w", encoding="utf-8") as file:
            file.write(text)
        source = os.path.dirname(os.path.dirname(genom.__file__))
        options = ["--strict", "--follow-imports=silent", "--cache-dir", folder]
        command = [sys.executable, "-m", "mypy", *options, script]
        done = subprocess.run(
            command, cwd=folder, env={**os.environ, "MYPYPATH": f"{folder}:{source}"},
            capture_output=True, text=True, timeout=WATCHDOG, check=False,
        )
        return done.stdout

    def test_a_type_checker_knows_services_ports_and_their_types(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(stubs.write(self.g, [], folder), [os.path.join(folder, "axis.pyi")])
            self.assertIn("no issues found", self.check(folder, RIGHT))
            # Indented where the type is known.
            lines = "".join(f"    {line}\n" for line in WRONG)
            told = self.check(folder, RIGHT + "if state is not None:\n" + lines)
            for line, wanted in WRONG.items():
                self.assertIn(wanted, told, line)
            self.assertIn(f"Found {len(WRONG)} errors", told)

    def test_editors_show_what_the_description_says(self):
        text = stubs.stub(self.demo)
        self.assertIn('"""Moves the axis to a position, and ends there.', text)
        self.assertIn('"""Gain applied to the speed', text)


if __name__ == "__main__":
    unittest.main()
