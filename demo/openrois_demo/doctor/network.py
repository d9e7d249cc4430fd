"""Findings about the network: interfaces, UDP ports, candidates, and STUN and TURN servers."""

import asyncio
import ipaddress
import random
import socket
from collections.abc import Sequence
from typing import Final

from openrois_streaming.network.interfaces import NoInterface, host_addresses
from openrois_streaming.network.servers import Servers, StunServer, TurnServer
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.peer.reach import Unreachable, relayed_by, seen_by

from openrois_demo.doctor.finding import Finding, Level

__all__ = ["candidates", "interfaces", "servers", "udp_ports"]

_SAMPLE: Final = 64
_ENOUGH: Final = 8
_SLOW: Final = 1.0


def interfaces(settings: NetworkSettings) -> Finding:
    """Return the addresses that media can use."""
    try:
        addresses = host_addresses(settings.interfaces)
    except NoInterface as error:
        return Finding(Level.FAIL, "interfaces", str(error), "Name one that is there, or none for all but loopback.")
    told = ", ".join(addresses) or "none"
    if not addresses:
        return Finding(Level.FAIL, "interfaces", told, "Bring a network interface up.")
    if all(ipaddress.ip_address(address).is_loopback for address in addresses):
        advice = "Only this machine can see the streams; a browser needs --allow-loopback-in-peer-connection for it."
        return Finding(Level.WARN, "interfaces", told, advice)
    return Finding(Level.OK, "interfaces", told)


def udp_ports(settings: NetworkSettings) -> Finding:
    """Check that sockets can be opened on the ports of media."""
    try:
        addresses = host_addresses(settings.interfaces)
    except NoInterface:
        return Finding(Level.FAIL, "UDP ports", "without an interface there are none")
    if settings.ports is None:
        failed = [address for address in addresses if not _binds(address, 0)]
        if failed:
            advice = "Leave that interface out with --interface and the names of the others."
            return Finding(Level.WARN, "UDP ports", f"no socket can be opened on {', '.join(failed)}", advice)
        return Finding(Level.OK, "UDP ports", "any; a firewall in front has to let all of them in")
    every = range(settings.ports.first, settings.ports.last + 1)
    tried = random.sample(every, min(len(every), _SAMPLE))
    free = sum(all(_binds(address, port) for address in addresses) for port in tried)
    told = f"{settings.ports.first}-{settings.ports.last}: {free} of {len(tried)} tried are free"
    if free == 0:
        return Finding(Level.FAIL, "UDP ports", told, "Choose another range with --udp-ports.")
    if free < min(_ENOUGH, len(tried)) or len(every) < _ENOUGH:
        advice = "Each viewer takes one for each interface, two while its connection is replaced; use a larger range."
        return Finding(Level.WARN, "UDP ports", told, advice)
    return Finding(Level.OK, "UDP ports", told)


def _binds(address: str, port: int) -> bool:
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, port))
        except OSError:
            return False
    return True


def candidates(settings: NetworkSettings, known: Servers) -> Finding:
    """Return the addresses that viewers would be given to send to."""
    if settings.relay_only:
        if known.turn:
            return Finding(Level.OK, "candidates", "relays alone")
        advice = "Give the gateway --turn and --turn-secret-file, or leave --relay-only out."
        return Finding(Level.FAIL, "candidates", "none: relays alone may be used, and there is no TURN server", advice)
    try:
        addresses = host_addresses(settings.interfaces)
    except NoInterface:
        return Finding(Level.FAIL, "candidates", "none without an interface")
    told = [each for each in addresses if settings.candidates == "lan" or settings.policy.permits(each)]
    if settings.public_address is not None:
        told.append(f"{settings.public_address} (public)")
    later = ["what STUN servers see"] * bool(known.stun) + ["relays"] * bool(known.turn)
    if told or later:
        return Finding(Level.OK, "candidates", f"profile {settings.candidates}: {', '.join((*told, *later))}")
    advice = "Give --public-address, a STUN server to the gateway (--ice-server), or choose --candidates lan."
    return Finding(Level.FAIL, "candidates", "none: no address here is one of the internet", advice)


async def servers(known: Servers) -> list[Finding]:
    """Check that each server answers, and how fast."""
    unusable = [Finding(Level.FAIL, "server", reason, "Correct its URL.") for reason in known.unusable]
    if not known and not unusable:
        advice = "Viewers in other networks need them: --ice-server, --turn and --turn-secret-file try some."
        return [Finding(Level.OK, "servers", "none given, which is right for one network", advice)]
    asked: Sequence[StunServer | TurnServer] = (*known.stun, *known.turn)
    return [*unusable, *await asyncio.gather(*(_ask(server) for server in asked))]


async def _ask(server: StunServer | TurnServer) -> Finding:
    is_turn = isinstance(server, TurnServer)
    name = "TURN server" if is_turn else "STUN server"
    try:
        reached = await (relayed_by(server) if isinstance(server, TurnServer) else seen_by(server))
    except Unreachable as error:
        advice = (
            "Check its address, the firewall on the way, and that its secret is the gateway's."
            if is_turn
            else "Connections are not slower for it, but viewers in other networks may not be reached."
        )
        return Finding(Level.FAIL if is_turn else Level.WARN, name, f"{server.url}: {error}", advice)
    does = "relays at" if is_turn else "sees this machine at"
    told = f"{server.url} {does} {reached.address}:{reached.port}, {1000 * reached.seconds:.0f} ms"
    if reached.seconds > _SLOW:
        return Finding(Level.WARN, name, told, "It is slow: a nearer one makes connections come up sooner.")
    return Finding(Level.OK, name, told)
