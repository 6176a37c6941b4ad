"""Proves to a daemon who holds a token, without sending it; docs/security.md specifies every byte.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import threading
from typing import Any, Dict, List, Optional, Tuple

from .errors import DaemonError

_PROTOCOL = b"genomd relay 1"


def _mac(key: bytes, *parts: bytes) -> bytes:
    return hmac.new(key, b"".join(parts), hashlib.sha256).digest()


class Token:
    """Keys derived from a token with HKDF (RFC 5869), one for each purpose."""

    def __init__(self, text: str) -> None:
        self._secret = _mac(b"genomd token", text.encode())

    def _key(self, *purpose: bytes) -> bytes:
        return _mac(self._secret, *purpose, b"\x01")

    def hint(self, nonce: bytes) -> bytes:
        """The hint by which the daemon finds the token."""
        return _mac(self._key(b"hint"), nonce)[:8]

    def keys(self, daemon: str, at: str, nonce: bytes, cookie: bytes) -> "Keys":
        """The keys of the session that a handshake establishes."""
        text = hashlib.sha256()
        for part in (_PROTOCOL, daemon.encode(), at.encode(), nonce, cookie):
            text.update(len(part).to_bytes(8, "big") + part)
        said = text.digest()
        proof = _mac(self._key(b"daemon"), said)
        return Keys(proof, self._key(b"requests", said), self._key(b"answers", said))


class Keys:
    """The keys of one session."""

    def __init__(self, proof: bytes, requests: bytes, answers: bytes) -> None:
        self.proof = proof
        self._requests = requests
        self._answers = answers

    def request(self, number: int, data: bytes) -> bytes:
        """Authentication code of a request."""
        return _mac(self._requests, number.to_bytes(8, "big"), data)

    def answer(self, number: int, data: bytes) -> bytes:
        """Authentication code of the answer to a request."""
        return _mac(self._answers, number.to_bytes(8, "big"), data)


def encode(head: Any, body: bytes = b"") -> bytes:
    """The bytes of a message: a line of JSON, then the body."""
    return json.dumps(head).encode() + b"\n" + body


def decode(message: bytes) -> Tuple[Dict[str, Any], bytes]:
    """Splits a message into head and body; the head is empty if the message is malformed."""
    line, _, body = message.partition(b"\n")
    try:
        head = json.loads(line)
    except ValueError:
        head = None
    return (head if isinstance(head, dict) else {}), body


class Greeting:
    """A hello that has not been answered yet."""

    def __init__(self, token: Token, daemon: str) -> None:
        self._token = token
        self._daemon = daemon
        self._nonce = os.urandom(32)

    def message(self) -> bytes:
        """The hello, as bytes to send."""
        hint = self._token.hint(self._nonce)
        hello = {"daemon": self._daemon, "nonce": self._nonce.hex(), "hint": hint.hex()}
        return encode({"hello": hello})

    def meet(self, answers: List[Tuple[str, bytes]]) -> "Session":
        """Establishes the session, if exactly one daemon answered and it holds the token."""
        found = [(at, *self._examine(at, message)) for at, message in answers]
        name = self._daemon
        if not found:
            raise DaemonError("daemon_silent", None, f"daemon `{name}` does not answer")
        if len(found) > 1:
            each = "; ".join(f"{at}, which {why}" for at, _, why in found)
            raise DaemonError(
                "several_daemons",
                None,
                f"{len(found)} answer to the name `{name}`: {each}; nothing was asked of them: "
                "stop all but one, or start each with a name of its own, `--daemon NAME`",
            )
        at, session, why = found[0]
        if session is None:
            raise DaemonError(
                "not_proved",
                None,
                f"what answers to the name `{name}` ({at}) {why}: it is another daemon, or your "
                "token is not in its token file; nothing was asked of it",
            )
        return session

    def _examine(self, source: str, message: bytes) -> Tuple[Optional["Session"], str]:
        head, _ = decode(message)
        if "refused" in head:
            return None, "does not know your token"
        try:
            hello = head["hello"]
            at = str(hello["at"])
            cookie, proof = bytes.fromhex(hello["cookie"]), bytes.fromhex(hello["proof"])
        except (KeyError, TypeError, ValueError):
            return None, "sends what is no answer of a genomd of this version"
        keys = self._token.keys(self._daemon, at, self._nonce, cookie)
        if not hmac.compare_digest(keys.proof, proof):
            return None, "does not prove that it holds your token"
        if at != source:
            return None, f"passes on what daemon {at} says"
        hint = self._token.hint(self._nonce)
        return Session(self._daemon, at, self._nonce, hint, cookie, keys), "holds your token"


class Session:
    """A session with a daemon that has proved itself; may be used from any thread."""

    def __init__(
        self, daemon: str, at: str, nonce: bytes, hint: bytes, cookie: bytes, keys: Keys
    ) -> None:
        self.at = at
        self._daemon = daemon
        self._head = {"nonce": nonce.hex(), "hint": hint.hex(), "cookie": cookie.hex()}
        self._keys = keys
        self._lock = threading.Lock()
        self._asked = 0

    def seal(self, question: bytes) -> Tuple[int, bytes]:
        """Seals a question; returns its bytes and its number."""
        with self._lock:
            self._asked += 1
            number = self._asked
        mac = self._keys.request(number, question)
        return number, encode(
            {"sealed": {**self._head, "number": number, "mac": mac.hex()}}, question
        )

    def open(self, number: int, message: bytes) -> bytes:
        """Checks the answer to the question of that number, and returns its content."""
        head, answer = decode(message)
        if isinstance(head.get("refused"), dict):
            told = head["refused"].get("message")
            raise DaemonError(
                "not_proved", None, f"daemon `{self._daemon}` is said to refuse: {told}"
            )
        try:
            mac = bytes.fromhex(head["sealed"]["mac"])
        except (KeyError, TypeError, ValueError):
            mac = b""
        if not hmac.compare_digest(mac, self._keys.answer(number, answer)):
            raise DaemonError(
                "not_proved",
                None,
                f"somebody changed the answer of daemon `{self._daemon}` on its way, or made one "
                "up; ask again",
            )
        return answer
