"""What the bodies can be asked for by name: their gestures, their places, their events."""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

from openrois.catalog.actuation import REACTION
from openrois.client import BodyInfo, Client, ConnectionLost, RoISError, RpcError, where
from openrois.types.profiles import component_urn
from openrois_agents.tools.names import Vocabulary, by_name, is_plain

__all__ = ["VocabularyReader", "gestures_of", "persons_of", "places_of"]

MAX_CHOICES: Final = 64
"""Names in one list of choices."""

_BODIES: Final = 32
_QUERY: Final = 2.0
_LASTS: Final = 10.0
"""Seconds for which names are not read again, where no component came or went: things of a scene may."""

_SURROUNDINGS: Final = component_urn("Surroundings", "OpenRoIS")
_MAP: Final = component_urn("Map", "OpenRoIS")

T = TypeVar("T")


async def gestures_of(client: Client, body: BodyInfo) -> Mapping[str, str]:
    """Return the references of a body's reactions by their names; none where it does not tell."""
    refs: list[str] = []
    for component_ref in body.refs(REACTION):
        answer = await _asked(client.component(component_ref).query("available_reactions"), {})
        refs += answer.get("available_reactions", ())
    return by_name(refs)


async def places_of(client: Client, body: BodyInfo) -> Mapping[str, str]:
    """Return the positions `x,y,th` of a body's places by their names: things and locations that do not move."""
    found = {name: position for name, kind, position in await _things_of(client, body) if kind != "person"}
    for component_ref in body.refs(_MAP):
        answer = await _asked(client.component(component_ref).query("locations"), {})
        columns = zip(answer.get("name", ()), answer.get("position_data", ()), strict=False)
        found |= {name: position for name, position in columns if is_plain(name)}
    return found


async def persons_of(client: Client, body: BodyInfo) -> Mapping[str, str]:
    """Return the positions `x,y,th` of the persons on a body's floor by their names, where the body knows of them."""
    return {name: position for name, kind, position in await _things_of(client, body) if kind == "person"}


async def _things_of(client: Client, body: BodyInfo) -> list[tuple[str, str, str]]:
    """Return name, kind and position of what the body has around it, where the name is a plain one."""
    found: list[tuple[str, str, str]] = []
    for component_ref in body.refs(_SURROUNDINGS):
        answer = await _asked(client.component(component_ref).query("things"), {})
        columns = zip(*(answer.get(each, ()) for each in ("name", "kind", "position_data")), strict=False)
        found += [(name, kind, position) for name, kind, position in columns if is_plain(name)]
    return found


@dataclass(slots=True)
class VocabularyReader:
    """Reads the names of all bodies, and again when something changed.

    Args:
        clock: monotonic seconds.
    """

    clock: Callable[[], float]
    _known: Vocabulary = field(default_factory=Vocabulary, init=False)
    _read_for: tuple[int, int] | None = field(default=None, init=False)
    _read_at: float = field(default=0.0, init=False)

    async def current(self, client: Client) -> Vocabulary:
        """Return the names now.

        Raises:
            RoISError, ConnectionLost, TimeoutError: the bodies cannot be listed.
        """
        read_for = (id(client), client.generation)
        if read_for != self._read_for or self.clock() - self._read_at > _LASTS:
            self._known = await _read(client)
            self._read_for, self._read_at = read_for, self.clock()
        return self._known


async def _read(client: Client) -> Vocabulary:
    bodies = (await client.bodies())[:_BODIES]
    gestures = await asyncio.gather(*(gestures_of(client, body) for body in bodies))
    places = await asyncio.gather(*(places_of(client, body) for body in bodies))
    return Vocabulary(
        _choices(body.engine_id for body in bodies),
        _choices(name for each in gestures for name in each),
        _choices(name for each in places for name in each),
        _choices(await _events(client, bodies)),
    )


async def _events(client: Client, bodies: Iterable[BodyInfo]) -> set[str]:
    """Return the names of all events; those of one type of component are read of one component."""
    one_of_each = {each.component_type: each.component_ref for body in bodies for each in body.components}
    names: set[str] = set()
    for component_ref in one_of_each.values():
        answer = await _asked(client.get_profile(where(component_ref=component_ref)), None)
        profiles = () if answer is None else answer.component_profiles.values()
        names |= {event.name for profile in profiles for event in profile.event_profiles}
    return names


async def _asked(question: Awaitable[T], otherwise: Any) -> T | Any:
    """Return an answer that comes soon, or something else."""
    try:
        async with asyncio.timeout(_QUERY):
            return await question
    except (ConnectionLost, RoISError, RpcError, TimeoutError):
        return otherwise


def _choices(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted({name for name in names if is_plain(name)})[:MAX_CHOICES])
