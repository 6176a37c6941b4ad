"""A component as a Python object, with services and ports as attributes."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from . import _signature
from ._daemon import Daemon, Part
from ._http import url
from ._outbox import Outbox
from .activity import Activity
from .errors import exception_class
from .port import Port, port_of


# `oneway` is the name of `send` in other clients.
_FLAGS = (*_signature.FLAGS, "oneway")


class Described(Part):
    """A component with its description; `genom.stubs` gives its members to type checkers."""

    def __init__(self, daemon: Daemon, description: Dict[str, Any]) -> None:
        super().__init__(daemon, description["name"])
        self._description = description
        self._outbox = Outbox()
        self._services = {one["name"]: one for one in description["services"]}
        self._ports = {
            one["name"]: port_of(daemon, self._name, one) for one in description["ports"]
        }
        if description.get("doc"):
            self.__doc__ = description["doc"]
        self.name = self._name
        for event in description.get("events", []):
            self.__dict__[event] = self._event(event)
        thrown = {name for one in self._services.values() for name in one["throws"]}
        for name in thrown:
            self.__dict__[name.rsplit("::", 1)[-1]] = exception_class(name)
        self.__dict__.update(self._ports)
        for name, one in self._services.items():
            self.__dict__[name] = self._function(one)

    def __call__(self, service: str, *args: Any, **inputs: Any) -> Any:
        """Calls a service by name: ``c('goto', 1.0, ack=True)``."""
        known = self._services.get(service)
        if known is None:
            # Asked for at each call: the component may have been reloaded.
            path = url("components", self._name, "services", service)
            known = self._client._transport.request("GET", path)
        return self._request(known, args, inputs)

    @property
    def ports(self) -> Mapping[str, Port]:
        """Its ports, by name."""
        return dict(self._ports)

    @property
    def services(self) -> Mapping[str, Callable[..., Any]]:
        """Its services, by name."""
        return {name: self._function(one) for name, one in self._services.items()}

    def activities(self) -> List[Dict[str, Any]]:
        """Its activities: running ones, and those that ended recently."""
        path = url("components", self._name, "activities")
        return list(self._client._transport.request("GET", path)["activities"])

    def statistics(self) -> Dict[str, Any]:
        """Statistics of its tasks and codels."""
        return dict(self._client._transport.request("GET", url("components", self._name, "tasks")))

    def stats(self) -> Dict[str, Any]:
        """The same, under the name that genomctl uses."""
        return self.statistics()

    def fire(self, event: str) -> None:
        """Fires an external event."""
        self._client._transport.request("POST", url("components", self._name, "events", event))

    def move(self, backend: str, port: Optional[str] = None) -> None:
        """Moves it, or one of its ports, to other middlewares: ``shm``, ``zenoh+ros2``."""
        path = url("components", self._name, "backend")
        self._client._transport.request("PUT", path, {"backend": backend, "port": port})

    def reload(self, library: Optional[str] = None) -> None:
        """Exchanges its library, by default for the present state of the file that it runs.

        IDS, ports, connections and activities stay as they are.
        """
        path = url("components", self._name, "reload")
        body = {} if library is None else {"library": str(library)}
        self._client._transport.request("POST", path, body)

    def unload(self) -> None:
        """Stops and unloads the component."""
        self._client._transport.request("DELETE", url("components", self._name))

    def __repr__(self) -> str:
        return f"<genom component {self._name}>"

    def _event(self, event: str) -> Callable[[], None]:
        def fire() -> None:
            self.fire(event)

        fire.__name__ = event
        fire.__doc__ = f"Fires event {event} of {self._name}."
        return fire

    def _function(self, service: Dict[str, Any]) -> Callable[..., Any]:
        def call(*args: Any, **inputs: Any) -> Any:
            return self._request(service, args, inputs)

        call.__name__ = service["name"]
        call.__qualname__ = f"{self._name}.{service['name']}"
        call.__doc__ = _signature.document(service)
        call.__signature__ = _signature.signature(service)  # type: ignore[attr-defined]
        return call

    def _request(self, service: Dict[str, Any], args: Tuple[Any, ...], given: Dict[str, Any]) -> Any:
        names = {_signature.python_name(one["name"]) for one in _signature.inputs(service)}
        flags = {flag: given.pop(flag, None) for flag in _FLAGS if flag not in names}
        zero = bool(flags.get("zero"))
        inputs = _signature.bind(service, args, given, zero)
        activity = Activity(self, service["name"], zero)
        callback = flags.get("callback")
        behind = flags.get("send") or flags.get("oneway")
        if service["name"] == "connect_port" and self._is_named(inputs):
            activity._take({"result": {}})
        elif behind or (callback is not None and not flags.get("ack")):
            self._outbox.put(activity, inputs)
        else:
            self._outbox.send(activity, inputs)
        if callback is not None:
            activity._call_back(callback)
        elif not behind and not flags.get("ack"):
            return self._finish(activity)
        return activity

    def _is_named(self, inputs: Dict[str, Any]) -> bool:
        """Whether `source` is the name of a publisher of this program that feeds the port."""
        here = f"{self._name}/{inputs.get('local')}"
        return self._client._named.get(str(inputs.get("remote"))) == here

    @staticmethod
    def _finish(activity: Activity) -> Dict[str, Any]:
        """Waits; if interrupted, aborts the activity, so that it does not run unattended."""
        try:
            return activity.wait()
        except KeyboardInterrupt:
            activity.abort()
            raise


class Component(Described):
    """A running component. Services, ports, events and exceptions are its attributes.

    A service takes precedence over a port of the same name, and both over the methods below. These
    can then be called as ``genom.Component.unload(component)``, and services as
    ``component('name')``.
    """

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        names = [*self._services, *self._ports, *self._description.get("events", [])]
        raise AttributeError(
            f"{self._name} has no service or port `{name}`{_signature.meant(name, names)}"
        )
