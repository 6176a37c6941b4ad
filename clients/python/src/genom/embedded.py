"""A daemon as a part of this program, which steps its clock."""

from __future__ import annotations

import contextlib
import glob
import os
import secrets
import shutil
import signal
import socket
import subprocess
import sysconfig
import tempfile
import time
import weakref
from typing import Any, Dict, List, NoReturn, Optional, Sequence, Union

from ._door import Door
from ._faults import Faults, Relay
from ._http import Transport, url
from ._place import Place
from ._target import resolve
from .activity import Activity, Status
from .client import Client
from .errors import DaemonError, RefusalError

# Seconds that the daemon may take to stop, beyond what its components may.
_STOPPING = 20.0


class Daemon(Client):
    """A daemon that runs as long as this object: a child of this program, with a clock that only
    `step` advances.

        with genom.Daemon() as d:
            arm = d.load("arm")
            goal, position = d.port("arm/goal"), d.port("arm/position")
            for _ in range(1000):
                goal.write(0.5)
                d.step(0.001)
                print(position.data)

    It is a `Client` of that daemon: components, services, connections, deployments, recordings are
    as with `connect`. `port` and `step` do not go through the control plane.
    """

    def __init__(
        self,
        *,
        clock: str = "virtual",
        path: Sequence[Union[str, "os.PathLike[str]"]] = (),
        config: Union[None, str, "os.PathLike[str]"] = None,
        options: Sequence[str] = (),
        program: Union[None, str, "os.PathLike[str]"] = None,
        timeout: Optional[float] = 10.0,
    ) -> None:
        """Starts a daemon, and returns when it is ready.

        ``path`` are directories to search for components; ``config`` is a configuration file of
        genomd, ``options`` are further options of its command line. ``program`` is genomd itself: by
        default ``$GENOMD``, or the one on ``PATH`` or beside this Python. Without a configuration file
        nothing of it reaches other daemons on this machine. ``timeout`` is that of `connect`.

        Raises DaemonError ``not_started`` with what the daemon said.
        """
        if clock != "virtual":
            raise ValueError(
                f"clock={clock!r}: a program steps the clock of its daemon, clock='virtual'; a daemon "
                "that lives by the machine's clock is one for genom.connect()"
            )
        program = _program(program)
        place = tempfile.mkdtemp(prefix="genomd-")
        # Of what has to have a name on this machine.
        name = self._name = f"genomd{secrets.token_hex(6)}"
        self._at = os.path.join(place, "genomd.sock")
        self.log = os.path.join(place, "log")
        """The file that the daemon logs to; it is removed when it has ended."""
        words = [program, "--embedded", "--clock", "virtual", "--socket", self._at]
        for directory in path:
            words += ["--path", os.path.abspath(os.fspath(directory))]
        words += ["--config", os.fspath(config)] if config is not None else _apart(place, name)
        words += ["--set", 'cells.without_daemon="stop"', *options]
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            with theirs, open(self.log, "wb") as log:
                # A session of its own: Ctrl-C is for this program.
                self._process: "subprocess.Popen[bytes]" = subprocess.Popen(
                    words, stdin=theirs.fileno(), stdout=subprocess.DEVNULL, stderr=log,
                    start_new_session=True,
                )
        except OSError as why:
            ours.close()
            shutil.rmtree(place, ignore_errors=True)
            raise DaemonError(
                "not_started", None,
                f"`{program}` does not run: {why.strerror}; put genomd on PATH, or name it in $GENOMD",
            ) from why
        # Also when this object is forgotten, or the program ends.
        self._finish = weakref.finalize(self, _end, self._process, ours, place, name)
        self._stepped = self._now = 0
        self._faults = Faults(self)
        self._begun: Optional[float] = None
        self._door = Door(ours, self._lost)
        try:
            self._check_version(self._door.hello())
            super().__init__(Transport(resolve(None, self._at, None, None, None, None, None, None), timeout))
        except BaseException:
            self._finish()
            raise

    @property
    def pid(self) -> int:
        """The process of the daemon."""
        return self._process.pid

    def deployed(self, within: float = 60.0) -> None:
        """Waits until all runs that the configuration names: components, connections, activities.

        Raises the reason if it does not within so many seconds of the machine.
        """
        end = time.monotonic() + within
        while True:
            try:
                self._transport.request("GET", "/ready?wait=0.2&deployed=true")
                return
            except RefusalError as error:
                if error.name != "not_ready" or time.monotonic() >= end:
                    raise

    @property
    def now(self) -> float:
        """The time of the clock in seconds, as of the last step."""
        return self._now / 1e9

    @property
    def real_time_factor(self) -> float:
        """How many seconds of the clock were stepped in one second of the machine, since the first
        step: with all that this program does between its steps. 0 before.
        """
        if self._begun is None:
            return 0.0
        return self._stepped / 1e9 / max(time.perf_counter() - self._begun, 1e-9)

    def step(self, seconds: float) -> float:
        """Advances the clock, and runs all that is due in that time; returns its new time.

        Values that were written to in ports are published first. If one is refused, `RefusalError` is
        raised, and time stays. A codel that does not return is waited for; Ctrl-C ends the wait.
        """
        nanoseconds = round(seconds * 1e9)
        if not 0 <= nanoseconds < 2**63:
            raise ValueError(f"a step of {seconds} s is none")
        return self._advance(nanoseconds) / 1e9

    def finish(self, activity: Activity, within: float = 60.0) -> Dict[str, Any]:
        """Steps the clock, from the end of one period to the next, until an activity has ended;
        returns its outputs, or raises its exception.

        Raises TimeoutError if it has not after ``within`` seconds of the clock; it goes on then.
        """
        period, end = self._faults.period(), self._now + round(within * 1e9)
        # What is due now comes first.
        self._advance(0)
        while activity.status == Status.SENT:
            if self._now >= end:
                raise TimeoutError(f"{activity} still runs after {within} s of the clock")
            self._advance(min(period - self._now % period, end - self._now))
        return activity.wait()

    def fault(
        self,
        port: Union[str, Place],
        *,
        drop: bool = False,
        delay: Optional[float] = None,
        corrupt: Any = None,
        every: int = 1,
        samples: Optional[int] = None,
    ) -> None:
        """From now on a connection does not work; ``port`` is the in port that reads it.

        Each sample is hit, or each third one with ``every=3``, or the first five with ``samples=5``:
        it is lost with ``drop``, comes ``delay`` seconds later, or has the members ``corrupt`` in place
        of its own. Another fault of the same port replaces the first.
        """
        if [drop, delay is not None, corrupt is not None].count(True) != 1:
            raise ValueError("a fault is one of drop=True, delay=SECONDS, corrupt=VALUE")
        if every < 1 or (samples is not None and samples < 0) or (delay is not None and delay < 0):
            raise ValueError("every is 1 or more, samples and delay are not negative")
        address = port.address() if isinstance(port, Place) else port
        late = None if delay is None else round(delay * 1e9)
        self._faults.add(Relay(address, drop, late, corrupt, every, samples))

    def repair(self, port: Union[str, Place]) -> None:
        """A connection that had a fault is as it was; samples on their way are lost."""
        self._faults.repair(port.address() if isinstance(port, Place) else port)

    def kill(self, cell: str) -> None:
        """Kills the process of a cell, and returns when it is back, or is to stay down."""
        before = self._cell(cell)
        if before.get("pid") is None:
            raise RefusalError("cell_down", f"cell {cell} is {before['state']}")
        os.kill(before["pid"], signal.SIGKILL)
        while True:
            now = self._cell(cell)
            back = now["state"] == "running" and now["starts"] > before["starts"]
            if back or now["state"] == "failed":
                return
            # Processes end and start in the machine's time.
            time.sleep(0.005)

    def _cell(self, name: str) -> Dict[str, Any]:
        cells = self._transport.request("GET", "/cells")["cells"]
        found = next((one for one in cells if one["name"] == name), None)
        if found is None:
            there = ", ".join(one["name"] for one in cells) or "there is none"
            raise RefusalError("no_such_cell", f"no cell {name}: {there}")
        return dict(found)

    def _advance(self, nanoseconds: int) -> int:
        """Steps the clock; returns its time in nanoseconds."""
        if self._begun is None:
            self._begun = time.perf_counter()
        if self._faults:
            self._now = self._faults.step(nanoseconds, self._door.step)
        else:
            self._now = self._door.step(nanoseconds)
        self._stepped += nanoseconds
        return self._now

    def port(self, port: Union[str, Place], element: Optional[str] = None) -> Any:
        """Shares the memory of a port, ``component/port`` or ``component.port``.

        Of an in port, `data` is what the next `write` publishes; of an out port, `data` is what codels
        have written last, as of the last step. Its type has to be of one size, without unbounded
        strings or sequences. The component may be in a cell, and begin again in another process.
        """
        from ._shared import SharedPort, shared

        address = port.address(element) if isinstance(port, Place) else port
        if not isinstance(port, Place) and element is not None:
            address = f"{address}/{element}"
        number, is_in, size, digest, file = self._door.open(address)

        def forget() -> None:
            # Nobody is there to forget it when the daemon has ended.
            if self._finish.alive and self._process.poll() is None:
                self._door.close_port(number)

        try:
            component, _, name = address.partition("/")
            where = url("components", component, "ports", name.partition("/")[0], "type")
            layout = self._transport.request("GET", where)
            if (layout["digest"], layout["types"][0]["size"]) != (digest, size):
                raise RefusalError("type_mismatch", f"{address} has just got another type: try again")
        except BaseException:
            os.close(file)
            forget()
            raise
        made: SharedPort = shared(address, layout, is_in, file, forget)
        return made

    def close(self) -> None:
        """Stops the daemon, and waits for its end."""
        self.disconnect()
        self._finish()
        # A thread that waits for a step has learnt by now that there is no daemon any more.
        self._door.close()

    def __enter__(self) -> "Daemon":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<genomd in process {self._process.pid}, a part of this program>"

    @staticmethod
    def _check_version(theirs: str) -> None:
        from . import __version__

        if theirs != __version__:
            raise DaemonError(
                "not_started", None,
                f"this is the package genom {__version__}, and genomd is {theirs}: "
                f"pip install genom=={theirs}",
            )

    def _lost(self) -> NoReturn:
        """The daemon has closed its end."""
        if not self._finish.alive:
            raise DaemonError("ended", None, "the daemon of this program was closed")
        try:
            status = self._process.wait(_STOPPING)
        except subprocess.TimeoutExpired:
            raise DaemonError("ended", None, "genomd does not answer any more") from None
        ready = hasattr(self, "_transport")
        said = _said(self.log)
        how = f"signal {_signal(-status)}" if status < 0 else f"exit status {status}"
        raise DaemonError(
            "ended" if ready else "not_started", None,
            f"genomd has ended ({how})" + (f": {said}" if said else ""),
        )


def _end(process: "subprocess.Popen[bytes]", end: socket.socket, place: str, name: str) -> None:
    """Ends the daemon: it stops when its socket is closed."""
    end.close()
    try:
        process.wait(_STOPPING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    shutil.rmtree(place, ignore_errors=True)
    # iceoryx2 leaves a segment in which it counts nodes, and a killed process all of its own.
    for segment in glob.glob(f"/dev/shm/{name}_*"):
        with contextlib.suppress(OSError):
            os.unlink(segment)


def _program(given: Union[None, str, "os.PathLike[str]"]) -> str:
    """Where genomd is."""
    if given is not None:
        return os.fspath(given)
    named = os.environ.get("GENOMD")
    if named:
        return named
    beside = os.path.join(sysconfig.get_path("scripts"), "genomd")
    return shutil.which("genomd") or (beside if os.access(beside, os.X_OK) else "genomd")


def _apart(place: str, name: str) -> List[str]:
    """Options with which nothing of a daemon reaches others."""
    settings = {
        "backends.shm.prefix": f"{name}_",
        "backends.shm.root": os.path.join(place, "shm"),
        "backends.zenoh.rendezvous": os.path.join(place, "zenoh"),
        "backends.ros2.networks": "loopback",
        "backends.ros2.namespace": name,
    }
    return [word for key, value in settings.items() for word in ("--set", f'{key}="{value}"')]


def _said(log: str) -> str:
    """The error in a log, else its last line."""
    try:
        with open(log, encoding="utf-8", errors="replace") as file:
            lines = [line.strip() for line in file.read().splitlines() if line.strip()]
    except OSError:
        return ""
    errors = [line[len("error: ") :] for line in lines if line.startswith("error: ")]
    return errors[0] if errors else lines[-1] if lines else ""


def _signal(number: int) -> str:
    try:
        return f"{number} ({signal.Signals(number).name})"
    except ValueError:
        return str(number)
