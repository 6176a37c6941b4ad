"""Compares what the client requests, and what it reads of replies, with the daemon's document: runs
the client's other tests again, checking each request and each access to a reply against
`/openapi.json`.
"""

import functools
import json
import re
from unittest import mock
from urllib.parse import parse_qs, urlsplit

import genom
from genom._http import Transport

from . import test_control, test_ports
from .support import WATCHDOG, DemoCase


class Undocumented(AssertionError):
    """Something that the document does not contain."""


class Document:
    """The daemon's OpenAPI document."""

    def __init__(self, document):
        self.schemas = document["components"]["schemas"]
        self.operations = [
            (method.upper(), re.compile(re.sub(r"\{[^}]*\}", "[^/]+", path) + "$"), operation)
            for path, item in document["paths"].items()
            for method, operation in item.items()
        ]

    def operation(self, method, path):
        """The operation of a request; its query has to be in the document, too."""
        parts = urlsplit(path)
        for known, template, operation in self.operations:
            if known == method and template.match(parts.path):
                names = {one["name"] for one in operation.get("parameters", [])}
                if not set(parse_qs(parts.query)) <= names:
                    raise Undocumented(f"{method} {path} has other parameters: {names}")
                return operation
        raise Undocumented(f"{method} {path} is no operation")

    def resolved(self, schema):
        """The schemas that a schema refers to: alternatives, and parts of one."""
        if "$ref" in schema:
            return self.resolved(self.schemas[schema["$ref"].rpartition("/")[2]])
        several = schema.get("oneOf") or schema.get("anyOf")
        if several:
            return [one for part in several for one in self.resolved(part)]
        if "allOf" not in schema:
            return [schema]
        whole = {"type": "object", "properties": {}, "required": []}
        for part in schema["allOf"]:
            for one in self.resolved(part):
                whole["properties"].update(one.get("properties", {}))
                whole["required"] += one.get("required", [])
        return [whole]

    def fits(self, value, schema):
        """The first of these schemas that a value matches; None if there is none."""
        return next((one for one in self.resolved(schema) if self._fits(value, one)), None)

    def _fits(self, value, schema):
        names = schema.get("type", [])
        names = [names] if isinstance(names, str) else names
        kind = {dict: "object", list: "array", str: "string", bool: "boolean", float: "number",
                int: "integer", type(None): "null"}[type(value)]
        if names and kind not in names and not (kind == "integer" and "number" in names):
            return False
        if "enum" in schema and value not in schema["enum"]:
            return False
        if isinstance(value, list):
            return all(self.fits(one, schema.get("items", {})) is not None for one in value)
        if not isinstance(value, dict):
            return True
        properties = schema.get("properties", {})
        return set(schema.get("required", [])) <= set(value) and all(
            self.fits(one, properties[name]) is not None
            for name, one in value.items() if name in properties
        )

    def watched(self, value, schema):
        """A reply that can be accessed by names of its schema only."""
        schema = self.fits(value, schema)
        if isinstance(value, list):
            return [self.watched(one, schema.get("items", {})) for one in value]
        if not isinstance(value, dict) or not schema.get("properties"):
            return value
        inside = schema["properties"]
        members = {
            name: self.watched(one, inside[name]) if name in inside else one
            for name, one in value.items()
        }
        return Watched(members, inside)


class Watched(dict):
    """An object of a reply, of which only members of its schema may be accessed."""

    def __init__(self, members, properties):
        super().__init__(members)
        self.properties = properties

    def __getitem__(self, name):
        self._known(name)
        return super().__getitem__(name)

    def get(self, name, default=None):
        self._known(name)
        return super().get(name, default)

    def _known(self, name):
        if name not in self.properties:
            raise Undocumented(f"`{name}` is not among {sorted(self.properties)}")


def compared(document, send, transport, method, path, text):
    """Sends a request of the client, checks it against the document, and wraps its reply."""
    operation = document.operation(method, path)
    body = operation.get("requestBody", {}).get("content", {})
    if text and "application/json" in body:
        given = json.loads(text)
        if document.fits(given, body["application/json"]["schema"]) is None:
            raise Undocumented(f"{method} {path} does not take {given}")
    reply = send(transport, method, path, text)
    answers = [
        one["content"]["application/json"]["schema"]
        for status, one in operation["responses"].items()
        if status.startswith("2") and "application/json" in one.get("content", {})
    ]
    # The client does not know which of the alternatives it received.
    schema = {"oneOf": answers}
    if document.fits(reply, schema) is None:
        raise Undocumented(f"{method} {path} answered {reply}")
    reply = document.watched(reply, schema)
    if isinstance(reply, Watched):
        parts = [part.get("properties", {}) for part in document.resolved(schema)]
        reply.properties = {name for part in parts for name in part}
    return reply


class Compared(DemoCase):
    """A test whose client is checked."""

    def setUp(self):
        document = Document(genom.connect()._transport.request("GET", "/openapi.json"))
        watch = mock.patch.object(
            Transport, "send", functools.partialmethod(_sent, document, Transport.send)
        )
        watch.start()
        self.addCleanup(watch.stop)
        self.document = document
        super().setUp()


def _sent(transport, document, send, method, path, text):
    return compared(document, send, transport, method, path, text)


class Services(Compared, test_control.Services):
    pass


class Ports(Compared, test_ports.Ports):
    pass


class Elsewhere(Compared):
    def test_the_daemon_is_asked_for_what_it_documents(self):
        self.assertEqual(self.g.stats(self.demo.name)["tasks"][0]["name"], "main")
        self.assertIn("[[component]]", self.g.dump())
        self.assertEqual(self.g.why(f"{self.demo.name}/parameter")[0].keys(), {"what", "fix", "remedies"})
        self.demo.move("local")
        self.demo.fire("emergency")
        self.assertEqual(self.demo.activities(), [])

    def test_changes_have_the_shape_that_is_documented(self):
        with self.g.events() as events:
            activity = self.demo.goto(goal=0.1, ack=True)
            for event in events:
                schema = self.document.fits(event, {"$ref": "#/components/schemas/Change"})
                self.assertIsNotNone(schema, event)
                self.assertLessEqual(set(event), set(schema["properties"]), event)
                if event["event"] == "activity_ended":
                    break
            activity.wait(WATCHDOG)

    def test_what_is_not_documented_is_found(self):
        with self.assertRaisesRegex(Undocumented, "is no operation"):
            self.g._transport.request("GET", "/robots")
        with self.assertRaisesRegex(Undocumented, "other parameters"):
            self.g._transport.request("GET", "/ports?vlaues=false")
        with self.assertRaisesRegex(Undocumented, "does not take"):
            self.g._transport.request("POST", "/connections", {"in": 3, "out": "a/b"})
        with self.assertRaisesRegex(Undocumented, "`nmae` is not among"):
            self.g._transport.request("GET", "/components")["components"][0]["nmae"]
