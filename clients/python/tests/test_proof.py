"""Proofs of tokens, with the values of the Rust tests and those of independent HMAC."""

import unittest

from genom import DaemonError
from genom._proof import Greeting, Token, decode, encode

TEXT = "0123456789abcdef0123456789abcdef"


def answer(hello, text, name, at):
    """The answer of a daemon that holds a token."""
    nonce = bytes.fromhex(decode(hello)[0]["hello"]["nonce"])
    keys = Token(text).keys(name, at, nonce, b"\x09" * 32)
    return keys, encode(
        {"hello": {"at": at, "cookie": "09" * 32, "proof": keys.proof.hex()}}
    )


class Proofs(unittest.TestCase):
    def test_the_codes_are_those_that_other_implementations_make(self):
        token = Token(TEXT)
        keys = token.keys("robot", "1f", b"\x01" * 32, b"\x02" * 32)
        self.assertEqual(token.hint(b"\x01" * 32).hex(), "ac21196dc2cbaee6")
        self.assertEqual(
            keys.proof.hex(), "ca8eaa2ce55c8a76dba1c97d5ff27163aa71fc9763d67023c9bbb19bf1366d3b"
        )
        self.assertEqual(
            keys.request(7, b"abc").hex(),
            "9dc470dce1c9cc32f7d325bb992f6695933f589ada063daf85b4d3642a8a1391",
        )
        self.assertEqual(
            keys.answer(7, b"abc").hex(),
            "3d80d179c59f243f91e0e2c136cd863844dc4c7c863bc2e131095d1513a0a876",
        )

    def test_only_one_that_holds_the_token_is_believed(self):
        for text, name, at, what in (
            ("x" * 32, "robot", "1f", "does not prove"),
            (TEXT, "arm", "1f", "does not prove"),
            (TEXT, "robot", "2f", "passes on what daemon 2f says"),
        ):
            greeting = Greeting(Token(TEXT), "robot")
            _, said = answer(greeting.message(), text, name, at)
            with self.assertRaisesRegex(DaemonError, what):
                greeting.meet([("1f", said)])
        greeting = Greeting(Token(TEXT), "robot")
        _, said = answer(greeting.message(), TEXT, "robot", "1f")
        with self.assertRaisesRegex(DaemonError, "2 answer to the name `robot`: 1f, which holds"):
            greeting.meet([("1f", said), ("66", b"")])
        with self.assertRaisesRegex(DaemonError, "does not answer"):
            greeting.meet([])
        self.assertEqual(greeting.meet([("1f", said)]).at, "1f")

    def test_answers_are_believed_once_and_unchanged(self):
        greeting = Greeting(Token(TEXT), "robot")
        keys, said = answer(greeting.message(), TEXT, "robot", "1f")
        session = greeting.meet([("1f", said)])
        (first, _), (second, _) = session.seal(b"one"), session.seal(b"two")
        sealed = encode({"sealed": {"mac": keys.answer(first, b"yes").hex()}}, b"yes")
        self.assertEqual(session.open(first, sealed), b"yes")
        for number, message in ((second, sealed), (first, sealed[:-1]), (first, b""), (first, b"[]")):
            with self.assertRaisesRegex(DaemonError, "changed the answer"):
                session.open(number, message)


if __name__ == "__main__":
    unittest.main()
