"""Ports over shared memory with the package iceoryx2, without the daemon."""

from __future__ import annotations

import ctypes
import os
import struct
import threading
import time
from typing import Any, Callable, Dict, Optional, Tuple

import iceoryx2 as iox2

from ._cdr import Cdr
from ._layout import Codec
from ._place import Place
from .errors import GenoMError, InputError, RefusalError

# Seconds of waiting for a sample in a busy loop, then between two checks: shared memory does not
# notify readers.
_EAGER = 0.002
_LOOK = 0.0002
# Initial size of messages, in bytes; it grows as needed.
_FIRST_ROOM = 4096
_BYTES = iox2.Slice[ctypes.c_uint8]
_DIGEST = iox2.AttributeKey.new("genom.digest")
_nodes: Dict[Tuple[Tuple[str, str], ...], Any] = {}
_nodes_lock = threading.Lock()


def _node(meet: Dict[str, str]) -> Any:
    """This process's node in the daemon's name space, created once."""
    key = tuple(sorted(meet.items()))
    with _nodes_lock:
        node = _nodes.get(key)
        if node is None:
            iox2.set_log_level(iox2.LogLevel.Fatal)
            config = iox2.config.default()
            config.global_cfg.prefix = iox2.FileName.new(meet["prefix"])
            config.global_cfg.root_path = iox2.Path.new(meet["root"])
            builder = iox2.NodeBuilder.new().config(config)
            # Ctrl-C is handled by the program.
            builder = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled)
            node = _nodes[key] = builder.create(iox2.ServiceType.Ipc)
    return node


class _End:
    """What both ends of a port have: the service that the daemon created, and the type."""

    def __init__(self, port: Place, address: str, buffers: bool = False) -> None:
        layout = port.layout()
        self.address = address
        fixed = layout["types"][0]["fixed"]
        # Types of fixed size are in C layout, others are CDR messages.
        self.codec: Optional[Codec] = Codec(layout, buffers) if fixed else None
        self.cdr: Optional[Cdr] = None if fixed else Cdr(layout, buffers)
        node = _node(port._client._meeting_point("shm"))
        try:
            builder = node.service_builder(iox2.ServiceName.new(address))
            builder = builder.publish_subscribe(self.codec.type if self.codec else _BYTES)
            self.service = builder.open()
        except Exception as why:
            raise RefusalError(
                "not_fast", f"{address} cannot be opened in shared memory: {why}"
            ) from why
        # Types of equal name and size may still differ, but not if their digests are equal.
        theirs = [str(one.to_string()) for one in self.service.attributes.key_values(_DIGEST)]
        if theirs and layout["digest"] not in theirs:
            raise RefusalError(
                "type_mismatch", f"{address} carries another type than {layout['type']}"
            )


class Writer:
    """Writer at an in port, over shared memory."""

    def __init__(self, port: Place, address: str) -> None:
        self._end = end = _End(port, address)
        self._publisher: Any = None
        self._any = False
        # The value published last, as a value of the port's layout if it has one.
        self._value: Any = None if end.cdr is None else end.cdr.zero()
        self._at = 0
        if end.codec is not None:
            self._value = end.codec.type()
            self._at = ctypes.addressof(self._value)
        try:
            self._publisher = self._builder().create()
        except Exception as why:
            raise RefusalError(
                "taken",
                f"{address} takes no publisher: {why}",
                help="another program publishes there: stop it first",
            ) from why

    def publish(self, value: Any) -> None:
        """Publishes a value: one copy, without a request to the daemon."""
        end = self._end
        try:
            if end.codec is not None:
                end.codec.put(self._at, value)
            elif end.cdr is not None:
                self._value = end.cdr.merge(self._value, value)
                message = end.cdr.encode(self._value)
        except (TypeError, ValueError, AttributeError, KeyError, struct.error) as why:
            raise InputError("bad_input", f"{end.address}: {why}") from why
        if self._publisher is None:
            raise GenoMError("ended", None, f"{end.address} is not fed any more")
        self._any = True
        try:
            if end.codec is not None:
                self._publisher.send_copy(self._value)
            else:
                self._send(message)
        except Exception as why:
            raise GenoMError(
                "middleware_failed", None, f"{end.address} takes no value: {why}; is shared memory full?"
            ) from why

    def last(self) -> Any:
        """The value published last; None if there was none."""
        if not self._any:
            return None
        return self._value if self._end.codec is None else self._end.codec.get(self._at)

    def repeat(self) -> None:
        """Publishes the last value again, for readers that connected after it."""
        if not self._any or self._publisher is None:
            return
        if self._end.codec is not None:
            self._publisher.send_copy(self._value)
        elif self._end.cdr is not None:
            self._send(self._end.cdr.encode(self._value))

    def close(self) -> None:
        """Closes the writer and frees the address."""
        if self._publisher is not None:
            self._publisher.delete()
            self._publisher = None

    def _builder(self) -> Any:
        builder = self._end.service.publisher_builder()
        if self._end.codec is not None:
            return builder
        told = self._end.service.static_config
        # One sample for each that readers may hold or have waiting, and one to write.
        most = told.subscriber_max_buffer_size + told.max_subscribers + 4
        return (
            builder.initial_max_slice_len(_FIRST_ROOM)
            .allocation_strategy(iox2.AllocationStrategy.PowerOfTwo)
            .override_sample_preallocation(most)
        )

    def _send(self, message: bytes) -> None:
        loan = self._publisher.loan_slice_uninit(len(message))
        ctypes.memmove(loan.payload_ptr, message, len(message))
        loan.assume_init().send()


class Reader:
    """Reader of a port, over shared memory."""

    ended = False

    def __init__(self, port: Place, address: str, depth: int, buffers: bool) -> None:
        self._end = end = _End(port, address, buffers)
        self._decode = self._from_message if end.codec is None else self._from_memory
        try:
            builder = end.service.subscriber_builder().buffer_size(depth)
            self._subscriber: Any = builder.create()
        except Exception as why:
            raise RefusalError("not_fast", f"{address} takes no reader: {why}") from why

    def take(self) -> Any:
        """The oldest value not taken yet; None if there is none."""
        while True:
            if self._subscriber is None:
                raise GenoMError("ended", None, f"{self._end.address} is not followed any more")
            sample = self._subscriber.receive()
            if sample is None:
                return None
            value = self._decode(sample)
            sample.delete()
            if value is not None:
                return value

    def wait(self, left: Optional[float], told: Callable[[], bool]) -> Any:
        """Waits for the oldest value not taken yet; None if none arrived in time, or something
        changed.
        """
        begin = time.monotonic()
        while not told():
            value = self.take()
            waited = time.monotonic() - begin
            if value is not None or (left is not None and waited >= left):
                return value
            if waited < _EAGER:
                os.sched_yield()
            else:
                time.sleep(_LOOK)
        return None

    def wake(self) -> None:
        """Nothing to do: `wait` checks for changes all the time."""

    def close(self) -> None:
        """Closes the reader."""
        if self._subscriber is not None:
            self._subscriber.delete()
            self._subscriber = None

    def _from_memory(self, sample: Any) -> Any:
        return self._end.codec.get(sample.payload_ptr) if self._end.codec else None

    def _from_message(self, sample: Any) -> Any:
        """The value of a message; None if it is not of this port's type."""
        message = ctypes.string_at(sample.payload_ptr, sample.header.number_of_elements)
        try:
            return self._end.cdr.decode(message) if self._end.cdr else None
        except (ValueError, IndexError, struct.error):
            return None
