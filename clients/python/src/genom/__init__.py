"""Client of genomd: supervise GenoM3 components from Python.

    >>> import genom
    >>> g = genom.connect()
    >>> demo = g.load('demo')
    >>> demo.set_speed(velocity=0.5)
    {}
    >>> a = demo.goto(goal=1.0, ack=True)
    >>> a.wait()
    {}
    >>> demo.position()
    {'position': {'position': 1.0, 'velocity': 0.0}}

``help(demo.goto)`` tells what the component's description says of a service.
"""

from . import event
from ._ends import Publisher, Subscription
from .activity import Activity, Status
from .client import Client, connect, update
from .component import Component
from .embedded import Daemon
from .errors import DaemonError, GenoMError, InputError, RefusalError
from .events import EventStream
from .port import Port, Reading
from .rate import Rate

__all__ = [
    "Activity",
    "Client",
    "Component",
    "Daemon",
    "DaemonError",
    "EventStream",
    "GenoMError",
    "InputError",
    "Port",
    "Publisher",
    "Rate",
    "Reading",
    "RefusalError",
    "Status",
    "Subscription",
    "connect",
    "event",
    "update",
]
__version__ = "0.1.0"
