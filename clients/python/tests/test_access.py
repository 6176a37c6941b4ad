"""Remote daemons, over TLS: with a token, with a certificate, by contexts of genomctl."""

import os
import sys
import unittest

import genom

HOST = os.environ.get("GENOM_HOST")


class Tokens(unittest.TestCase):
    def test_a_token_comes_in_by_tls(self):
        with genom.connect(HOST, ca="ca.pem", token_file="admin") as g:
            demo = g.component("demo")
            self.assertEqual(demo.get_speed(), {"velocity": 0.5})
            with g.events() as events:
                demo.goto(0.0)
                self.assertEqual(next(events)["component"], "demo")
        with open("read", encoding="utf-8") as file:
            token = file.read().split('token = "')[1].split('"')[0]
        with genom.connect(HOST, ca="ca.pem", token=token) as g:
            with self.assertRaisesRegex(genom.RefusalError, "needs the right `call`"):
                g.component("demo").set_speed(2.0)

    def test_what_takes_long_is_waited_for(self):
        with genom.connect(HOST, ca="ca.pem", token_file="admin", timeout=1.0) as g:
            demo = g.component("demo")
            demo.reset()
            # Longer than the timeout, with no message of the daemon meanwhile.
            self.assertEqual(demo.goto(1.2), {})

    def test_nothing_is_taken_on_trust(self):
        with self.assertRaisesRegex(ValueError, "whose certificate to trust"):
            genom.connect(HOST, token_file="read")
        with self.assertRaisesRegex(genom.DaemonError, "certificate verify failed.*root"):
            genom.connect(HOST, ca="client.pem", token_file="read")
        with self.assertRaisesRegex(genom.RefusalError, "a token is needed here"):
            genom.connect(HOST, ca="ca.pem")
        with self.assertRaisesRegex(ValueError, "others may read it"):
            genom.connect(HOST, ca="ca.pem", token_file="ca.pem")
        with self.assertRaisesRegex(ValueError, "in the clear"):
            genom.connect("http://robot:7300")

    def test_the_contexts_of_genomctl_are_known(self):
        # `robot` is the current context.
        for options in ({}, {"context": "robot"}):
            with genom.connect(**options) as g:
                self.assertEqual(g.components(), ["demo"])
                self.assertEqual(repr(g), f"<genomd on {HOST}>")
        with self.assertRaisesRegex(ValueError, "no context `rbot`; there is: .*robot"):
            genom.connect(context="rbot")
        # Arguments take precedence over the context.
        with self.assertRaises(genom.DaemonError):
            genom.connect(socket="/nowhere/socket")

    def test_contexts_are_read_without_tomllib_too(self):
        from genom._target import plain_toml

        with open(os.path.join(os.environ["XDG_CONFIG_HOME"], "genomd/contexts.toml")) as file:
            text = file.read()
        read = plain_toml(text)
        self.assertEqual(read["current"], "robot")
        self.assertEqual(read["context"]["robot"]["host"], HOST)
        self.assertEqual(read["context"]["it's \"spare\""], {"socket": "/nowhere/socket"})
        if sys.version_info >= (3, 11):
            import tomllib

            self.assertEqual(read, tomllib.loads(text))
        with self.assertRaisesRegex(ValueError, "line 1"):
            plain_toml("port = 7300")


class Certificates(unittest.TestCase):
    def test_a_certificate_stands_for_a_token(self):
        with genom.connect(HOST, ca="ca.pem", cert="client-both.pem") as g:
            self.assertEqual(g.components(), ["demo"])
            with self.assertRaisesRegex(genom.RefusalError, "needs the right `admin`"):
                g.load("demo", "-i", "other")
        with self.assertRaises(genom.DaemonError):
            genom.connect(HOST, ca="ca.pem")


if __name__ == "__main__":
    unittest.main()
