"""Candidates of a description, and the description with one candidate in place of them all. Pure.

A text is an SDP, a candidate-attribute (RFC 8839 section 5.1) with or without `a=`, or a message of the wire with one
of them in its params. Other texts pass unchanged.
"""

import ipaddress
import json
import re
from typing import Any

Address = tuple[str, int]

_CANDIDATE = re.compile(r"(?:a=)?candidate:(\S+) (\d+) (\S+) (\d+) (\S+) (\d{1,5}) typ (\S+)[^\r\n]*")
_CONNECTION = re.compile(r"^c=IN IP[46] [^\r\n]*", re.MULTILINE)
_PORT = re.compile(r"^(m=\w+) (\d+)", re.MULTILINE)
_HIDDEN_PORT = "9"  # the port without a candidate, RFC 8840 section 4.1.3

# As a host candidate of RFC 8445 section 5.1.2.1 for the only component.
_PRIORITY = 126 << 24 | 65535 << 8 | 255
_FIELDS = ("sdp", "candidate")


def addresses(text: str) -> list[Address]:
    """Return the addresses of the UDP candidates of RTP in `text`, those with the highest priority first.

    Only literal IP addresses count, no mDNS names.
    """
    found = [
        (int(priority), (host, int(port)))
        for body in _bodies(text)
        for _, component, protocol, priority, host, port, _ in _CANDIDATE.findall(body)
        if component == "1" and protocol.lower() == "udp" and _is_address(host) and 0 < int(port) < 2**16
    ]
    found.sort(key=lambda each: -each[0])
    return list(dict.fromkeys(address for _, address in found))


def rerouted(text: str, to: Address) -> str:
    """Return `text` with `to` in place of every candidate and other address."""
    message = _message(text)
    if message is None:
        return _rerouted(text, to)
    for field in _FIELDS:
        if isinstance(message["params"].get(field), str):
            message["params"][field] = _rerouted(message["params"][field], to)
    return json.dumps(message)


def _rerouted(text: str, to: Address) -> str:
    host, port = to
    candidate = f"candidate:0 1 udp {_PRIORITY} {host} {port} typ host"
    if "\n" not in text:
        return _CANDIDATE.sub(lambda found: _prefix(found[0]) + candidate, text)
    sections = re.split(r"(?m)^(?=m=)", text)
    text = "".join(_one_candidate(section, f"a={candidate}") for section in sections)
    version = ipaddress.ip_address(host).version
    text = _CONNECTION.sub(f"c=IN IP{version} {host}", text)
    return _PORT.sub(lambda found: f"{found[1]} {found[2] if found[2] in ('0', _HIDDEN_PORT) else port}", text)


def _one_candidate(section: str, candidate: str) -> str:
    """Return the section with `candidate` in place of its first candidate, and without the others."""
    lines: list[str] = []
    for line in section.splitlines(keepends=True):
        if not line.startswith("a=candidate:"):
            lines.append(line)
        elif candidate:
            lines.append(candidate + line[len(line.rstrip("\r\n")) :])
            candidate = ""
    return "".join(lines)


def _prefix(attribute: str) -> str:
    return "a=" if attribute.startswith("a=") else ""


def _bodies(text: str) -> list[str]:
    message = _message(text)
    if message is None:
        return [text]
    return [message["params"][field] for field in _FIELDS if isinstance(message["params"].get(field), str)]


def _message(text: str) -> dict[str, Any] | None:
    """Return `text` as a message of the wire with params by name, if it is one."""
    if not text.lstrip().startswith("{"):
        return None
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return message if isinstance(message.get("params"), dict) else None


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
