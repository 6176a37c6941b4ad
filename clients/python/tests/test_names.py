"""Names that scripts of the field's Python client use, and further needs of supervisors."""

import asyncio
import os
import tempfile
import unittest

import genom

from .support import WATCHDOG, DemoCase


class Names(DemoCase):
    def test_localhost_is_the_daemon_of_this_user(self):
        with genom.connect("localhost") as g:
            self.assertIn(self.demo.name, g.components())

    def test_a_loop_over_update_and_status_ends(self):
        self.demo.set_speed({"velocity": 2.0})
        activity = self.demo.goto({"goal": 0.1}, ack=True)
        while activity.status == genom.Status.sent:
            genom.update()
            self.g.update()
        self.assertEqual(activity.status, genom.Status.done)
        self.assertIs(genom.Status.error, genom.Status.ERROR)
        with self.assertRaises(genom.event.GenoMError):
            self.demo.goto({"goal": 50.0})

    def test_unload_takes_a_name_a_library_or_a_component(self):
        library = os.environ["GENOM_DEMO"]
        genom.Component.unload(self.demo)
        for which in (lambda other: "passing", lambda other: library, lambda other: other):
            other = self.g.load(library, "-i", "passing")
            self.g.unload(which(other))
            self.assertNotIn("passing", self.g.components())
        with self.assertRaises(genom.GenoMError):
            self.g.unload("passing")
        # Removed by the test's cleanup.
        self.g.load(library, "-i", self.demo.name)

    def test_what_is_sent_without_waiting_keeps_its_order(self):
        for number in range(50):
            self.demo.set_speed(number / 50, send=True)
        self.assertEqual(self.demo.get_speed(), {"velocity": 49 / 50})
        self.demo.set_speed(0.125, oneway=True)
        self.assertEqual(self.demo.get_speed(), {"velocity": 0.125})
        # If one of them is refused, the others are not affected.
        self.demo.set_speed(9.0, send=True)
        self.demo.set_speed("fast", send=True)
        self.demo.set_speed(0.25, send=True)
        with self.assertRaises(genom.InputError):
            self.demo.set_speed("fast")
        self.assertEqual(self.demo.get_speed(), {"velocity": 0.25})

    def test_activities_are_awaited(self):
        other = self.load()
        self.demo.set_speed(2.0)

        async def work():
            first = self.demo.goto(0.1, ack=True)
            self.assertEqual(await asyncio.gather(first, other.goto(0.0, send=True)), [{}, {}])
            # Awaiting an ended one again.
            self.assertEqual(await first, {})
            with self.assertRaises(self.demo.OUT_OF_RANGE):
                await self.demo.goto(50.0, ack=True)
            long = self.start_slow()
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(long, 0.01)
            long.abort()
            return await long

        self.assertEqual(asyncio.run(asyncio.wait_for(work(), WATCHDOG)), {})

    def test_a_publisher_has_a_name_that_the_port_is_connected_to(self):
        for connect in (
            lambda: self.demo.connect_port({"local": "parameter", "remote": "my_gain"}),
            lambda: self.demo.connect_port("parameter", "my_gain"),
            lambda: self.g.connect_port(self.demo.parameter.address(), "my_gain"),
        ):
            with self.demo.parameter("my_gain").publisher() as p:
                connect()
                p(0.5)
                here = self.demo.parameter.address()
                self.assertEqual(self.demo.parameter.connected(), here)
        with self.assertRaises(genom.GenoMError):
            self.demo.connect_port("parameter", "your_gain")

    def test_a_read_port_offers_its_ends(self):
        read = self.demo.position()
        self.assertEqual(list(read), ["position"])
        with read.subscribe(fast=False) as positions:
            self.assertEqual(positions.wait(WATCHDOG), read["position"])

    def test_elements_are_connected(self):
        viewer = self.g.load(os.path.join(os.environ["GENOM_FIXTURES"], "viewer.gen"))
        self.addCleanup(genom.Component.unload, viewer)
        viewer.image.connect("camera/image/left", element="eye", wait=True, backend="shm")
        self.assertEqual(viewer.image.connected("eye"), "camera/image/left")
        self.assertIn("camera/image/left", self.g.why("viewer/image/eye")[0]["what"])
        viewer.image("eye").disconnect()
        with viewer.image("eye").publisher(fast=False) as p:
            p(number=3)
            self.assertEqual(viewer.see("eye")["frame"]["number"], 3)


class Supervision(DemoCase):
    def test_a_system_is_frozen_and_thawed(self):
        with tempfile.TemporaryDirectory() as scratch:
            file = os.path.join(scratch, "robot.json")
            self.g.freeze(file)
            self.assertEqual(os.stat(file).st_mode & 0o777, 0o600)
            with self.assertRaises(genom.RefusalError) as refused:
                self.g.thaw(file)
            self.assertEqual(refused.exception.name, "name_taken")
            thawed = self.g.thaw(file, replace=True)
            self.assertEqual({name: [] for name in thawed}, thawed)

    def test_a_deployment_is_dumped_and_applied(self):
        self.demo.set_speed(0.75)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "robot.toml")
            with open(file, "w", encoding="utf-8") as opened:
                opened.write(self.g.dump())
            genom.Component.unload(self.demo)
            planned = self.g.apply(file, dry_run=True)
            self.assertNotIn(self.demo.name, self.g.components())
            self.assertEqual(self.g.apply(file), planned)
            self.assertIn(self.demo.name, self.g.components())
            self.assertEqual(self.g.apply(file), [])

    def test_statistics_count_under_both_names(self):
        self.assertEqual(self.g.stats(self.demo.name).keys(), self.demo.stats().keys())

    def test_a_recording_is_a_whole_file(self):
        magic = b"\x89MCAP0\r\n"
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "run.mcap")
            with self.g.record(file, self.demo.name) as recording:
                self.demo.goto(0.0)
                self.assertIn(self.demo.name, recording.close())
            with open(file, "rb") as opened:
                written = opened.read()
            self.assertTrue(written.startswith(magic) and written.endswith(magic))
            with self.assertRaisesRegex(genom.GenoMError, "is there already"):
                self.g.record(file)


if __name__ == "__main__":
    unittest.main()
