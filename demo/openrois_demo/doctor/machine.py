"""Findings about this machine: its browser, port, clock and load. Needs no extra."""

import os
import socket
import time
from pathlib import Path

from openrois_streaming.testing.chromium import find_chromium

import openrois
from openrois_demo.doctor.finding import Finding, Level

__all__ = ["browser", "clock", "load", "port"]


def browser() -> Finding:
    """Look for a browser that shows the page."""
    found = find_chromium()
    if found is not None:
        return Finding(Level.OK, "browser", found)
    advice = "Any browser with WebRTC shows the page; `openrois bench latency` measures in Chromium or Chrome."
    return Finding(Level.WARN, "browser", "neither Chromium nor Chrome is found here", advice)


def port(number: int) -> Finding:
    """Check that the gateway's TCP port is free."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", number))
        except OSError as error:
            advice = "A gateway may be running there already; another one takes --port."
            return Finding(Level.WARN, "gateway's port", f"TCP {number} is taken ({error.strerror})", advice)
    return Finding(Level.OK, "gateway's port", f"TCP {number} is free")


def clock() -> Finding:
    """Check that the time of day can be right: credentials of TURN servers expire by it."""
    now, installed = time.time(), Path(openrois.__file__).stat().st_mtime
    told = time.strftime("%Y-%m-%d %H:%M:%S %Z", time.localtime(now))
    if now < installed:
        advice = "Set the clock (a time server does it for good): credentials of TURN servers expire by it."
        return Finding(Level.WARN, "clock", f"{told}, which is before OpenRoIS was installed here", advice)
    return Finding(Level.OK, "clock", told)


def load() -> Finding:
    """Check that the machine has time for encoders."""
    if not hasattr(os, "getloadavg"):
        return Finding(Level.OK, "load", "this system does not report its load")
    cores, busy = os.cpu_count() or 1, os.getloadavg()[0]
    told = f"load {busy:.1f} on {cores} cores"
    if busy < cores:
        return Finding(Level.OK, "load", told)
    return Finding(
        Level.WARN, "load", told, "What else runs here takes time from the encoders; pictures will come late."
    )
