"""Services, activities, signatures and errors, with the standard library only."""

import asyncio
import contextlib
import http.server
import inspect
import os
import pydoc
import threading
import unittest
from unittest import mock

import genom

from .support import WATCHDOG, DemoCase


class Services(DemoCase):
    def test_inputs_go_by_name_by_place_and_as_a_dict(self):
        demo = self.demo
        for call in (
            lambda: demo.set_speed(velocity=0.25),
            lambda: demo.set_speed(0.25),
            lambda: demo("set_speed", 0.25),
            lambda: demo("set_speed", velocity=0.25),
            lambda: demo.set_speed({"velocity": 0.25}),
        ):
            demo.set_speed(1.0)
            self.assertEqual(call(), {})
            self.assertEqual(demo.get_speed(), {"velocity": 0.25})
        # Without inputs, an attribute keeps its values.
        demo.set_speed()
        self.assertEqual(demo.get_speed(), {"velocity": 0.25})
        # Or takes its defaults, on request.
        demo.set_speed(zero=True)
        self.assertEqual(demo.get_speed(), {"velocity": 0.5})
        self.assertIn("velocity: float = ?", str(inspect.signature(demo.set_speed)))

    def test_an_activity_without_flags_returns_when_it_has_ended(self):
        self.demo.set_speed(2.0)
        self.assertEqual(self.demo.goto(goal=0.1), {})
        self.assertEqual(self.demo.position(), {"position": {"position": 0.1, "velocity": 0.0}})
        self.assertEqual(self.demo.position.read()["position"], 0.1)

    def test_an_exception_is_raised_with_its_name_and_members(self):
        with self.assertRaises(genom.GenoMError) as caught:
            self.demo.goto(50.0)
        self.assertEqual(caught.exception.name, "::demo::OUT_OF_RANGE")
        self.assertEqual(caught.exception.detail["upper"], 10.0)
        with self.assertRaises(self.demo.OUT_OF_RANGE):
            self.demo.set_speed(9.0)

    def test_a_wrong_name_suggests_the_nearest(self):
        with self.assertRaisesRegex(AttributeError, "did you mean `goto`?"):
            self.demo.gotoo
        with self.assertRaisesRegex(genom.RefusalError, "did you mean `goto`?") as caught:
            self.demo("gotoo")
        self.assertEqual(caught.exception.name, "no_such_service")
        with self.assertRaisesRegex(TypeError, "did you mean `velocity`?"):
            self.demo.set_speed(velocty=1.0)
        with self.assertRaisesRegex(genom.RefusalError, "no component"):
            self.g.component("nobody")

    def test_wrong_inputs_are_refused_before_anything_runs(self):
        with self.assertRaisesRegex(genom.InputError, "goal: expected double"):
            self.demo.goto(goal="far")
        with self.assertRaises(ValueError):
            self.demo.goto([1.0])
        with self.assertRaisesRegex(TypeError, "takes 1 inputs, 2 were given"):
            self.demo.goto(1.0, 2.0)
        with self.assertRaisesRegex(TypeError, "twice"):
            self.demo.goto(1.0, goal=2.0)
        self.assertEqual(self.demo.activities(), [])

    def test_numbers_that_json_does_not_have_are_sent_too(self):
        with self.assertRaises(self.demo.OUT_OF_RANGE):
            self.demo.goto(float("inf"))


class Activities(DemoCase):
    def test_ack_returns_an_activity_that_is_followed(self):
        activity = self.start_slow()
        self.assertEqual(activity.status, genom.Status.SENT)
        self.assertEqual(activity.status, "sent")
        self.assertIsNone(activity.result)
        with self.assertRaises(TimeoutError):
            activity.wait(0.02)
        activity.abort()
        # genom3.md 7.5: a stop codel that yields ether ends the activity well.
        self.assertEqual(activity.wait(WATCHDOG), {})
        self.assertEqual((activity.status, activity.result), ("done", {}))
        activity.abort()

    def test_several_wait_for_one_activity(self):
        activity = self.start_slow()
        ends = []
        waiters = [
            threading.Thread(target=lambda: ends.append(activity.wait(WATCHDOG))) for _ in range(2)
        ]
        for waiter in waiters:
            waiter.start()
        activity.abort()
        for waiter in waiters:
            waiter.join(WATCHDOG)
        self.assertEqual(ends, [{}, {}])

    def test_ack_holds_an_exception_and_wait_raises_it(self):
        activity = self.demo.goto(goal=50.0, ack=True)
        self.assertEqual(activity.status, "error")
        self.assertIsInstance(activity.exception, self.demo.OUT_OF_RANGE)
        with self.assertRaises(self.demo.OUT_OF_RANGE):
            activity.wait()

    def test_send_returns_at_once_and_tells_what_was_refused(self):
        activity = self.demo.goto(goal=0.0, send=True)
        self.assertEqual(activity.wait(WATCHDOG), {})
        refused = self.demo.goto(goal="far", send=True)
        with self.assertRaises(genom.InputError):
            refused.wait(WATCHDOG)

    def test_a_callback_gets_the_activity_when_it_has_ended(self):
        told = threading.Event()
        heard = []

        def ended(activity):
            heard.append((activity.status, activity.exception))
            told.set()

        activity = self.demo.goto(goal=50.0, callback=ended)
        self.assertIsInstance(activity, genom.Activity)
        self.assertTrue(told.wait(WATCHDOG))
        self.assertEqual(heard[0][0], "error")
        self.assertEqual(heard[0][1].detail["value"], 50.0)

    def test_an_interrupted_call_leaves_nothing_running(self):
        with self.g.events() as events:
            with mock.patch.object(genom.Activity, "wait", side_effect=KeyboardInterrupt):
                with self.assertRaises(KeyboardInterrupt):
                    self.demo.goto(10.0)
            ended = next(event for event in events if event["event"] == "activity_ended")
        self.assertEqual(ended["component"], self.demo.name)
        self.assertLess(self.demo.position.read()["position"], 10.0)

    def test_an_event_of_the_component_is_an_attribute(self):
        activity = self.start_slow()
        self.demo.emergency()
        with self.assertRaises(self.demo.HALTED):
            activity.wait(WATCHDOG)


class Descriptions(DemoCase):
    def test_signatures_come_from_the_description(self):
        parameters = inspect.signature(self.demo.goto).parameters
        self.assertEqual(list(parameters), ["goal", "ack", "send", "zero", "callback"])
        self.assertEqual((parameters["goal"].default, parameters["goal"].annotation), (1.0, float))

    def test_help_tells_what_the_description_says(self):
        shown = pydoc.plain(pydoc.render_doc(self.demo.goto))
        for wanted in ("goto(goal: float = 1.0", "Moves the axis to a position", "Position to reach, m"):
            self.assertIn(wanted, shown)
        shown = pydoc.plain(pydoc.render_doc(self.demo.parameter))
        self.assertIn("Gain applied to the speed", shown)

    def test_completion_lists_services_ports_and_events(self):
        listed = dir(self.demo)
        for wanted in ("goto", "set_speed", "position", "parameter", "emergency", "OUT_OF_RANGE"):
            self.assertIn(wanted, listed)


class Daemons(DemoCase):
    def test_load_attaches_to_what_runs(self):
        name = self.demo.name
        self.assertEqual(self.g.load(name).name, name)
        self.assertEqual(self.g.load("demo", "-i", name).name, name)
        self.assertEqual(self.g.load(os.environ["GENOM_DEMO"]).name, name)
        self.assertEqual(self.g.components(), [name])
        with self.assertRaises(genom.RefusalError):
            self.g.load("no_such_library")

    def test_scripts_for_other_clients_find_their_names(self):
        self.assertIn("/opt", self.g.rpath("/opt"))
        self.assertIsNone(self.g.update())
        self.g.disconnect()
        # Connections are opened again when needed.
        self.assertEqual(self.demo.get_speed(), {"velocity": 0.5})

    def test_no_daemon_says_how_to_start_one(self):
        with self.assertRaisesRegex(genom.DaemonError, "start one with `genomd LIBRARY...`"):
            genom.connect(socket="/nowhere/genomd.sock")
        with self.assertRaises(ValueError):
            genom.connect(host="nowhere")


class Other(http.server.BaseHTTPRequestHandler):
    """A server that is not genomd and records who asks."""

    def do_GET(self):
        body = self.server.answer
        self.server.asked.append(self.headers["Authorization"])
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


class Tcp(unittest.TestCase):
    def serve(self, answer):
        server = http.server.HTTPServer(("127.0.0.1", 0), Other)
        server.answer, server.asked = answer, []
        thread = threading.Thread(target=server.handle_request)
        thread.start()
        self.addCleanup(server.server_close)
        self.addCleanup(thread.join, WATCHDOG)
        return server

    def test_a_token_goes_with_requests_over_tcp(self):
        server = self.serve(b'{"genomd": "0"}')
        genom.connect(f"127.0.0.1:{server.server_port}", token="secret").disconnect()
        self.assertEqual(server.asked, ["Bearer secret"])

    def test_what_is_no_genomd_is_told_apart(self):
        server = self.serve(b"<html>")
        with self.assertRaisesRegex(genom.DaemonError, "is no genomd"):
            genom.connect(host=f"127.0.0.1:{server.server_port}")


class Events(DemoCase):
    def test_events_reach_a_callback(self):
        told = threading.Event()
        heard = []

        def take(event):
            heard.append(event)
            if event["event"] == "activity_ended":
                told.set()

        with self.g.events(take):
            self.demo.goto(0.0)
            self.assertTrue(told.wait(WATCHDOG))
        self.assertIn("activity_started", [event["event"] for event in heard])

    def test_a_listener_that_was_away_hears_how_much_it_missed(self):
        with self.g.events() as events:
            self.demo.emergency()
            self.assertIn("event_fired", (event["event"] for event in events))
            # More changes than the daemon keeps happen before it is connected again.
            events._connection.sock.shutdown(2)
            for _ in range(1100):
                self.demo.emergency()
            with contextlib.suppress(self.demo.HALTED):
                self.demo.goto(0.0)
            missed, fired = 0, 0
            for event in events:
                missed += event["changes"] if event["event"] == "missed" else 0
                fired += event["event"] == "event_fired"
                if event["event"] == "activity_ended" and event["service"] == "goto":
                    break
            self.assertLess(fired, 1100)
            # On a busy machine there are reports of overruns among those missed.
            self.assertGreaterEqual(missed + fired, 1100)

    def test_events_are_iterated_asynchronously(self):
        async def watch():
            seen = []
            stream = self.g.events()
            self.demo.goto(0.0, send=True)
            async for event in stream:
                seen.append(event["event"])
                if event["event"] == "activity_ended":
                    return seen

        seen = asyncio.run(asyncio.wait_for(watch(), WATCHDOG))
        self.assertEqual((seen[0], seen[-1]), ("activity_started", "activity_ended"))

    def test_a_stream_that_breaks_goes_on_where_it_was(self):
        with self.g.events() as events:
            self.demo.goto(0.0)
            first = next(events)
            events._connection.sock.shutdown(2)
            rest = [next(events)]
            while rest[-1]["event"] != "activity_ended":
                rest.append(next(events))
        self.assertEqual(first["event"], "activity_started")
        self.assertNotIn("activity_started", [event["event"] for event in rest])

    def test_closing_a_stream_ends_who_reads_it(self):
        events = self.g.events()
        seen = []
        reader = threading.Thread(target=lambda: seen.extend(events))
        reader.start()
        events.close()
        reader.join(WATCHDOG)
        self.assertFalse(reader.is_alive())


if __name__ == "__main__":
    unittest.main()
