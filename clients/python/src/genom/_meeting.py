"""Sessions of zenoh by which this process meets a daemon.

Daemons of one machine meet in a directory of sockets. If the daemon listens nowhere else, this
process joins them there as a peer, so that samples take the direct way. Otherwise it is a client of
the daemon's session, and reaches everything that session reaches.
"""

from __future__ import annotations

import atexit
import fcntl
import json
import os
import threading
import time
from typing import Any, Dict, List, Optional

import zenoh

# Seconds to wait for a matching end; an existing one takes far less.
MATCHING = 5.0
# Maximum length of the path of a Unix socket on Linux; zenoh puts a file `.lock` beside it.
_LONGEST = 107 - len(".lock")

_sessions: Dict[str, Any] = {}
_sockets: List[str] = []
_lock = threading.Lock()


def session(meet: Dict[str, str]) -> Any:
    """The session with the daemon's, created once."""
    with _lock:
        opened = _sessions.get(meet["connect"])
        if opened is None or opened.is_closed():
            folder = meet.get("rendezvous")
            opened = None if folder is None else _peer(folder)
            if opened is None:
                opened = _open("client", [], meet["connect"].split(","))
            _sessions[meet["connect"]] = opened
    return opened


def _open(mode: str, listen: List[str], connect: List[str]) -> Any:
    config = zenoh.Config()
    for key, value in (
        ("mode", mode),
        ("listen/endpoints", listen),
        ("connect/endpoints", connect),
        ("scouting/multicast/enabled", False),
        ("scouting/gossip/enabled", False),
    ):
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def _peer(folder: str) -> Optional[Any]:
    """Joins the daemons as they do themselves: the holder of the directory's lock connects to the
    existing sockets, and adds one that later processes connect to.
    """
    own = os.path.join(folder, f"{os.getpid()}-python{len(_sockets)}.sock")
    if len(own.encode()) > _LONGEST:
        return None
    try:
        lock = os.open(folder, os.O_RDONLY)
    except OSError:
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        there = [os.path.join(folder, name) for name in sorted(os.listdir(folder))]
        there = [path for path in there if path.endswith(".sock") and _is_alive(path)]
        _sockets.append(own)
        opened = _open("peer", [f"unixsock-stream/{own}"], [f"unixsock-stream/{path}" for path in there])
    finally:
        os.close(lock)
    # Opening waits for the other sessions, but not for long.
    begin = time.monotonic()
    while len(opened.info.peers_zid()) < len(there) and time.monotonic() - begin < MATCHING:
        time.sleep(0.001)
    return opened


def _is_alive(socket: str) -> bool:
    """Whether a session listens there: zenoh locks a file beside the socket meanwhile."""
    try:
        lock = os.open(socket + ".lock", os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(lock)
    return False


@atexit.register
def _close() -> None:
    with _lock:
        for opened in _sessions.values():
            opened.close()
        _sessions.clear()
        for own in _sockets:
            for path in (own, own + ".lock"):
                try:
                    os.unlink(path)
                except OSError:
                    pass
        _sockets.clear()
