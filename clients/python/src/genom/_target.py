"""Selects the daemon by the rules of genomctl."""

from __future__ import annotations

import ipaddress
import json
import os
import re
import ssl
import sys
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional


@dataclass
class Target:
    """A daemon, and how to reach it."""

    socket: Optional[str] = None
    name: str = ""
    port: int = 0
    tls: Optional[ssl.SSLContext] = None
    # Name of another daemon, to which this one relays requests.
    daemon: Optional[str] = None
    token: Optional[str] = field(default=None, repr=False)
    # The options that select it for genomctl, except a token that was passed as text.
    options: List[str] = field(default_factory=list)

    def __str__(self) -> str:
        if self.socket is None:
            where = f"[{self.name}]" if ":" in self.name else self.name
            return f"{'https://' if self.tls else ''}{where}:{self.port}"
        return self.socket if self.daemon is None else f"{self.socket} for zenoh:{self.daemon}"


def resolve(
    target: Optional[str],
    socket: Optional[str],
    host: Optional[str],
    token: Optional[str],
    token_file: Optional[str],
    ca: Optional[str],
    cert: Optional[str],
    context: Optional[str],
) -> Target:
    """The daemon selected by the arguments of `connect`, completed with those of a context."""
    if target in ("localhost", "127.0.0.1", "::1"):
        # This machine without a port: its default socket, unless other options say more.
        target = None
    if target is not None:
        if "://" in target or target.startswith("zenoh:") or "/" not in target:
            host = target
        else:
            socket = target
    if socket is not None and host is not None and not host.startswith("zenoh:"):
        raise TypeError("connect() takes a socket or a host, not both")
    socket = socket if socket is not None or host is not None else os.environ.get("GENOMD_SOCKET")
    token_file = token_file or os.environ.get("GENOMD_TOKEN_FILE")
    says = socket is not None or host is not None
    if context is not None or not says:
        kept = _context(context)
        if not says:
            socket, host = kept.get("socket"), kept.get("host")
        ca, cert = ca or kept.get("ca"), cert or kept.get("cert")
        token_file = token_file or kept.get("token_file")
    if token is None and token_file is not None:
        token = _read_token(token_file)
    at = os.fspath(socket or _default_socket())
    if host is None:
        found = Target(socket=at, token=token)
    elif host.startswith("zenoh:"):
        found = Target(socket=at, daemon=host[len("zenoh:") :], token=token)
    else:
        found = _by_tcp(host, token, ca, cert)
    named = (("--socket", found.socket), ("--host", host), ("--token-file", token_file),
             ("--ca", ca), ("--cert", cert))
    found.options = [word for name, value in named if value for word in (name, os.fspath(value))]
    return found


def _by_tcp(host: str, token: Optional[str], ca: Optional[str], cert: Optional[str]) -> Target:
    scheme, _, rest = host.rpartition("://")
    name, colon, port = rest.rstrip("/").rpartition(":")
    name = name.strip("[]")
    if not name or not port.isdigit() or scheme not in ("", "http", "https"):
        raise ValueError(f"`{host}` is no ADDRESS:PORT, https://NAME:PORT or zenoh:NAME")
    found = Target(name=name, port=int(port), token=token)
    if scheme == "https" or scheme == "" and (ca is not None or not _is_here(name)):
        if ca is None:
            raise ValueError(
                f"{host}: nothing says whose certificate to trust; ca=FILE names the root of the "
                "daemon's certificate"
            )
        found.tls = ssl.create_default_context(cafile=ca)
        if cert is not None:
            with open(cert, "rb") as file:
                if os.fstat(file.fileno()).st_mode & 0o077:
                    raise ValueError(f"the key file {cert}: others may read it; `chmod 600` it")
            found.tls.load_cert_chain(cert)
    elif not _is_here(name):
        raise ValueError(
            f"{host} is another machine: the token would go in the clear; use https:// and ca=FILE"
        )
    return found


def _is_here(name: str) -> bool:
    """Whether the address is on this machine (loopback)."""
    try:
        return name == "localhost" or ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def _default_socket() -> str:
    directory = os.environ.get("XDG_RUNTIME_DIR")
    if directory:
        return os.path.join(directory, "genomd.sock")
    return f"/tmp/genomd-{os.getuid()}/genomd.sock"


def _read_token(path: str) -> str:
    """Reads a token: the only content of a file, or the first of a token file."""
    with open(path, encoding="utf-8") as file:
        if os.fstat(file.fileno()).st_mode & 0o077:
            raise ValueError(f"the token file {path}: others may read it; `chmod 600` it")
        text = file.read()
    written = re.search(r'^token\s*=\s*"([^"]*)"', text, re.MULTILINE)
    token = written[1] if written else text.strip()
    if not re.fullmatch("[!-~]+", token):
        raise ValueError(f"the token file {path}: it holds no token; one line, the token alone")
    return token


def _context(name: Optional[str]) -> Dict[str, Any]:
    """The options of the context of that name, or of the current one."""
    base = os.environ.get("XDG_CONFIG_HOME") or os.path.join(os.environ.get("HOME", ""), ".config")
    path = os.path.join(base, "genomd", "contexts.toml")
    try:
        with open(path, encoding="utf-8") as file:
            kept = _toml(file.read())
    except FileNotFoundError:
        kept = {}
    except ValueError as why:
        raise ValueError(f"{path}: {why}") from why
    contexts = kept.get("context", {})
    name = name or kept.get("current")
    if name is None:
        return {}
    if name not in contexts:
        raise ValueError(f"no context `{name}`; there is: {', '.join(contexts) or 'none'}")
    return dict(contexts[name])


if sys.version_info >= (3, 11):
    from tomllib import loads as _toml
else:

    def _toml(text: str) -> Dict[str, Any]:
        return plain_toml(text)


def plain_toml(text: str) -> Dict[str, Any]:
    """Parses the TOML that genomctl writes (tables of texts), for Python without `tomllib`."""
    whole: Dict[str, Any] = {}
    table = whole
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        if line.startswith("[") and line.endswith("]"):
            table = whole
            for part in re.findall(r'"(?:[^"\\]|\\.)*"|[\w-]+', line[1:-1]):
                table = table.setdefault(json.loads(part) if part[0] == '"' else part, {})
            continue
        key, _, value = (part.strip() for part in line.partition("="))
        quoted = value[:1]
        if not re.fullmatch(r"[\w-]+", key) or quoted not in ('"', "'") or value[-1] != quoted:
            raise ValueError(f"line {number} is not understood: {line}")
        table[key] = json.loads(value) if quoted == '"' else value[1:-1]
    return whole
