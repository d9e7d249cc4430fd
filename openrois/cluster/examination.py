"""A look at NATS from outside: whether it serves gateways, and which of them are heard there."""

import asyncio
import secrets
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from statistics import median
from typing import Final

from openrois.aio.tasks import Deadline
from openrois.cluster.connection import NatsConnection
from openrois.cluster.frames import MAX_BEAT, Beat, FrameFault, parse_said
from openrois.cluster.presence import RANKS, SILENCE
from openrois.cluster.settings import NatsSettings
from openrois.cluster.subjects import Subjects

__all__ = ["HeardGateway", "NatsServerFacts", "examine_server", "hear_gateways"]

_ECHOES: Final = 5
_PATIENCE: Final = 1.0
"""Seconds that a message may take to come back."""

_LISTENING: Final = 1.5 * SILENCE
_HEARD: Final = 1024
"""Processes of gateways that are heard."""


@dataclass(frozen=True, slots=True)
class NatsServerFacts:
    """What one server of NATS is and does.

    Attributes:
        version: of its program.
        max_payload: bytes of a message that it takes.
        round_trip: seconds from a message to its coming back, the median of some; None where one did not come back.
    """

    version: str
    max_payload: int
    round_trip: float | None


@dataclass(frozen=True, slots=True)
class HeardGateway:
    """A process that gave a sign of life.

    Attributes:
        gateway_id: of which gateway.
        instance: the token of the process.
        version: of its program.
        ranks: that it knows, as one text with commas, as it says; empty where it says none.
    """

    gateway_id: str
    instance: str
    version: str
    ranks: str = ""


async def examine_server(settings: NatsSettings, server: str, size: int) -> NatsServerFacts:
    """Send one server messages of `size` bytes that come back over a subject as gateways use them.

    Raises:
        Unreachable: it does not answer, or does not admit a gateway.
    """
    connection = await NatsConnection.open(settings, server, "openrois doctor")
    try:
        return NatsServerFacts(
            connection.version, connection.max_payload, await _echo(connection, Subjects(settings.prefix), size)
        )
    finally:
        connection.abort("examined")


async def _echo(connection: NatsConnection, subjects: Subjects, size: int) -> float | None:
    token, came, payload = secrets.token_hex(8), asyncio.Event(), bytes(min(size, connection.max_payload))
    connection.subscribe(subjects.streams(token), lambda _subject, _headers, _payload: came.set())
    taken = []
    for _ in range(_ECHOES):
        came.clear()
        began = time.perf_counter()
        connection.publish(subjects.stream(token, 0), payload)
        try:
            with Deadline(_PATIENCE):
                await came.wait()
        except TimeoutError:
            return None
        taken.append(time.perf_counter() - began)
    return median(taken)


async def hear_gateways(settings: NatsSettings, server: str) -> list[HeardGateway]:
    """Listen for longer than a gateway may be silent, and return what is heard, by id.

    Raises:
        Unreachable: the server does not answer, or does not admit a gateway.
    """
    heard: dict[str, HeardGateway] = {}
    connection = await NatsConnection.open(settings, server, "openrois doctor")
    try:
        connection.subscribe(Subjects(settings.prefix).beats, _noting(heard))
        with suppress(TimeoutError), Deadline(_LISTENING):
            await connection.lost.wait()
    finally:
        connection.abort("examined")
    return sorted(heard.values(), key=lambda gateway: (gateway.gateway_id, gateway.instance))


def _noting(heard: dict[str, HeardGateway]) -> Callable[[bytes, bytes, bytes], None]:
    def note(_subject: bytes, _headers: bytes, payload: bytes) -> None:
        try:
            beat = parse_said(Beat, payload, MAX_BEAT)
        except FrameFault:
            return
        if beat.leaving:
            heard.pop(beat.instance, None)
        elif beat.instance in heard or len(heard) < _HEARD:
            ranks = str(beat.attributes.get(RANKS, ""))
            heard[beat.instance] = HeardGateway(beat.gateway, beat.instance, beat.version, ranks)

    return note
