"""Steps that go through memory, and those that go by message instead."""

import mmap
import os
import socket
import struct
import threading
import unittest
from unittest import mock

import genom
from genom import _door
from genom._slate import Slate

HEAD = struct.Struct("=II")
STEPPED = struct.Struct("=IIQI")
REFUSAL = b'{"error": {"name": "bad_input", "message": "no"}}'
HELLO, STEP, SLATE, TELL = 0, 1, 6, 7


class Daemon:
    """What a daemon does with messages, and with requests on the slate while it `looks` there.

    A step returns its argument; one by 0 is refused.
    """

    def __init__(self, end, has_slate=True):
        self.end, self.has_slate = end, has_slate
        self.asked, self.short, self.last = [], [], None
        self.file = os.memfd_create("slate")
        os.ftruncate(self.file, 192)
        self.memory = mmap.mmap(self.file, 192)
        self.looks = self.ends = False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def words(self, at):
        return struct.unpack_from("=I", self.memory, at)[0]

    def look(self, looks):
        self.looks = looks
        struct.pack_into("=I", self.memory, 128, looks)

    def glance(self):
        """Does what is on the slate."""
        number, verb = struct.unpack_from("=II", self.memory, 0)
        (nanoseconds,) = struct.unpack_from("=Q", self.memory, 8)
        if number == self.words(64):
            return
        assert verb == STEP, verb
        self.short.append(nanoseconds)
        self.last = (number, nanoseconds)
        struct.pack_into("=IQ", self.memory, 68, int(nanoseconds == 0), nanoseconds)
        struct.pack_into("=I", self.memory, 64, number)

    def run(self):
        self.end.settimeout(0)
        while not self.ends:
            if self.looks:
                self.glance()
            try:
                message = self.end.recv(4096)
            except BlockingIOError:
                os.sched_yield()
                continue
            if not message:
                return
            self.answer(message)

    def answer(self, message):
        self.glance()
        number, verb = HEAD.unpack_from(message)
        self.asked.append(verb)
        if verb == SLATE and self.has_slate:
            socket.send_fds(self.end, [HEAD.pack(number, 0)], [self.file])
            return
        value = None
        if verb == HELLO:
            self.end.send(HEAD.pack(number, 0) + struct.pack("=Q", 0) + b"1.2.3")
            return
        if verb == STEP:
            (value,) = struct.unpack_from("=Q", message, 8)
        elif verb == TELL:
            (told,) = struct.unpack_from("=I", message, 8)
            value = self.last[1] if self.last and self.last[0] == told else None
        self.end.send(STEPPED.pack(number, 0, value, 0) if value else HEAD.pack(number, 1) + REFUSAL)

    def close(self):
        self.ends = True
        self.thread.join()
        self.end.close()
        os.close(self.file)


@unittest.skipUnless(Slate.serves(), "Python orders what it writes on x86 only")
class SlateTest(unittest.TestCase):
    def door(self, awake, **options):
        patched = mock.patch.object(_door, "_AWAKE", awake)
        patched.start()
        self.addCleanup(patched.stop)
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        daemon = Daemon(theirs, **options)
        self.addCleanup(daemon.close)
        door = _door.Door(ours, lambda: self.fail("the daemon has closed its end"))
        self.addCleanup(door.close)
        self.assertEqual(door.hello(), "1.2.3")
        door._looks = True
        return door, daemon

    def test_steps_need_no_message_while_both_are_awake(self):
        door, daemon = self.door(60.0)
        daemon.look(True)
        self.assertEqual([door.step(n) for n in (1, 2, 2**63)], [1, 2, 2**63])
        with self.assertRaises(genom.RefusalError):
            door.step(0)
        self.assertEqual(door.step(3), 3)
        self.assertEqual(daemon.short, [1, 2, 2**63, 0, 3])
        # What was refused is told by message.
        self.assertEqual(daemon.asked, [HELLO, SLATE, TELL])

    def test_a_daemon_that_sleeps_or_has_no_slate_is_sent_messages(self):
        for has_slate in (True, False):
            door, daemon = self.door(60.0, has_slate=has_slate)
            self.assertEqual([door.step(n) for n in (1, 2)], [1, 2])
            self.assertEqual((daemon.short, daemon.asked), ([], [HELLO, SLATE, STEP, STEP]))

    def test_one_that_falls_asleep_is_woken_and_does_the_step_once(self):
        door, daemon = self.door(1e-6)
        daemon.look(True)
        # As if it fell asleep after the program saw it awake.
        daemon.looks = False
        self.assertEqual(door.step(5), 5)
        self.assertEqual((daemon.short, daemon.asked), ([5], [HELLO, SLATE, TELL]))
        # It took long, so the next one goes by message, which is slept for.
        self.assertEqual(door.step(6), 6)
        self.assertEqual((daemon.short, daemon.asked[3:]), ([5], [STEP]))

    def test_a_step_that_was_interrupted_is_done_before_the_next(self):
        door, daemon = self.door(60.0)
        daemon.look(True)
        daemon.looks = False
        asked = Slate.step

        def interrupted(slate, number, nanoseconds, _):
            self.assertIsNone(asked(slate, number, nanoseconds, 0.0))
            raise KeyboardInterrupt

        for argument in (7, 0):
            with mock.patch.object(Slate, "step", interrupted), self.assertRaises(KeyboardInterrupt):
                door.step(argument)
        daemon.looks = True
        self.assertEqual(door.step(8), 8)
        self.assertEqual(daemon.short, [7, 0, 8])


if __name__ == "__main__":
    unittest.main()
