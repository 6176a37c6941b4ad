"""Ports straight through shared memory, with the package iceoryx2 and without the daemon."""

from __future__ import annotations

import ctypes
import threading
from typing import Any, Dict, Optional, Tuple

import iceoryx2 as iox2

from ._ends import Publisher, Subscription, look_until
from ._layout import Codec
from ._place import Place
from .errors import GenoMError, InputError, RefusalError

_DIGEST = iox2.AttributeKey.new("genom.digest")
_nodes: Dict[Tuple[Tuple[str, str], ...], Any] = {}
_nodes_lock = threading.Lock()


def _node(meet: Dict[str, str]) -> Any:
    """This process's node where the daemon's ports are; made once."""
    key = tuple(sorted(meet.items()))
    with _nodes_lock:
        node = _nodes.get(key)
        if node is None:
            iox2.set_log_level(iox2.LogLevel.Fatal)
            config = iox2.config.default()
            config.global_cfg.prefix = iox2.FileName.new(meet["prefix"])
            config.global_cfg.root_path = iox2.Path.new(meet["root"])
            builder = iox2.NodeBuilder.new().config(config)
            # Ctrl-C is the program's.
            builder = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled)
            node = _nodes[key] = builder.create(iox2.ServiceType.Ipc)
    return node


def _open(port: Place, address: str) -> Tuple[Any, Codec]:
    """The service of a port, which the daemon has made, and its type."""
    layout = port.layout()
    codec = Codec(layout)
    node = _node(port._client._meeting_point("shm"))
    try:
        builder = node.service_builder(iox2.ServiceName.new(address))
        service = builder.publish_subscribe(codec.type).open()
    except Exception as why:
        raise RefusalError("not_fast", f"{address} cannot be opened in shared memory: {why}") from why
    # Two types of one name and size may still differ: the digests tell.
    theirs = [str(one.to_string()) for one in service.attributes.key_values(_DIGEST)]
    if theirs and layout["digest"] not in theirs:
        raise RefusalError("type_mismatch", f"{address} carries another type than {layout['type']}")
    return service, codec


class ShmPublisher(Publisher):
    """The writing end of an in port, straight through shared memory."""

    fast = True

    def __init__(self, port: Place, element: Optional[str]) -> None:
        super().__init__(port, element)
        self._service, self._codec = _open(port, port.address(element))
        try:
            self._publisher: Any = self._service.publisher_builder().create()
        except Exception as why:
            raise RefusalError(
                "taken",
                f"{port.address(element)} takes no publisher: {why}",
                help="another program publishes there: stop it first",
            ) from why
        # What was published last, in the layout of the port.
        self._value = self._codec.type()
        self._at = ctypes.addressof(self._value)

    def publish(self, value: Any) -> None:
        """Publishes a value: one copy, no call of the daemon."""
        try:
            self._codec.put(self._at, value)
        except (TypeError, ValueError, AttributeError, KeyError) as why:
            raise InputError("bad_input", f"{self.port.address(self._element)}: {why}") from why
        if self._publisher is None:
            raise GenoMError("ended", None, f"{self.port.address(self._element)} is not fed any more")
        self._publisher.send_copy(self._value)

    def close(self) -> None:
        """Takes the connection away and lets go of the address."""
        super().close()
        if self._publisher is not None:
            self._publisher.delete()
            self._publisher = None


class ShmSubscription(Subscription):
    """The reading end of a port, straight through shared memory."""

    fast = True

    def __init__(self, port: Place, element: Optional[str], depth: int) -> None:
        self.port = port
        self._last = None
        self._service, self._codec = _open(port, str(port._source(element)))
        self._get = self._codec.get
        try:
            self._subscriber: Any = self._service.subscriber_builder().buffer_size(depth).create()
        except Exception as why:
            raise RefusalError(
                "not_fast", f"{port.address(element)} takes no reader: {why}"
            ) from why

    def take(self) -> Any:
        """The oldest value not taken yet; None when there is none."""
        if self._subscriber is None:
            raise GenoMError("ended", None, f"{self.port.address()} is not followed any more")
        sample = self._subscriber.receive()
        if sample is None:
            return None
        self._last = self._get(sample.payload_ptr)
        sample.delete()
        return self._last

    def wait(self, timeout: Optional[float] = None) -> Any:
        """The oldest value not taken yet, as soon as there is one; TimeoutError if none comes."""
        return look_until(self.take, timeout, self.port.address())

    def close(self) -> None:
        """Stops following."""
        if self._subscriber is not None:
            self._subscriber.delete()
            self._subscriber = None
