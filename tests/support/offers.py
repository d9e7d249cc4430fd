"""Buses that offer what a test says, and random changes of them."""

import asyncio
from typing import Any, Final, cast

from hypothesis import strategies as st

from openrois.contract import ComponentBus, Directory
from openrois.engine.engine import Engine
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier
from tests.support.streams import FakeStreams

__all__ = ["CHANGES", "Bus", "attach", "bodies", "change", "component", "engine", "offer", "shape"]


def component(name: str, urn: str = "urn:a") -> HRIComponentProfile:
    """Return the profile of a component."""
    return HRIComponentProfile(identifier=RoISIdentifier(code=urn), name=name)


def engine(engine_id: str, *names: str, below: tuple[HRIEngineProfile, ...] = ()) -> HRIEngineProfile:
    """Return the profile of an engine with components of these names."""
    refs = tuple(f"{engine_id}/{name}" for name in names)
    return HRIEngineProfile(identifier=RoISIdentifier(code=engine_id), component_ids=refs, sub_profiles=below)


def offer(profile: HRIEngineProfile, urn: str = "urn:a") -> Directory:
    """Return the directory of an engine; all of its components are of one type."""
    return Directory(profile, {ref: component(ref.partition("/")[2], urn) for ref in profile.component_refs()})


class Bus:
    """A bus that offers what it is set to."""

    def __init__(self, offered: Directory, streaming: tuple[str, ...] = ()) -> None:
        self.offered = offered
        self.extension = FakeStreams() if streaming else None
        if self.extension is not None:
            self.extension.engines = lambda: frozenset(streaming)  # type: ignore[method-assign]

    async def discover(self) -> Directory:
        return self.offered


def shape(profile: HRIEngineProfile) -> Any:
    """Return a profile without the order of its engines."""
    return (
        profile.identifier,
        profile.parameter_profiles,
        profile.own_refs(),
        frozenset(profile.component_ids),
        frozenset(map(shape, profile.sub_profiles)),
    )


async def attach(engine: Engine, *offers: Directory) -> list[Bus]:
    """Attach a bus for each offer."""
    buses = [Bus(each) for each in offers]
    for bus in buses:
        await engine.attach(cast(ComponentBus, bus))
    return buses


def bodies(count: int) -> list[Directory]:
    """Return the offers of bodies with two components each."""
    return [offer(engine(f"body{number}", "arm", "eye")) for number in range(count)]


_OFFERS: Final = st.one_of(
    st.none(),
    st.builds(
        lambda names, below, urn: (tuple(sorted(names)), tuple(sorted(below)), urn),
        st.sets(st.sampled_from("xyz")),
        st.dictionaries(st.sampled_from("pqr"), st.booleans()).map(lambda found: frozenset(found.items())),
        st.sampled_from(["urn:a", "urn:b"]),
    ),
)


def _made(engine_id: str, names: tuple[str, ...], below: tuple[tuple[str, bool], ...], urn: str) -> Directory:
    def sub(name: str, has_more: bool) -> HRIEngineProfile:
        deeper = (engine(f"{engine_id}{name}-deeper", "w"),) if has_more else ()
        return engine(f"{engine_id}{name}", "v", below=deeper)

    return offer(engine(engine_id, *names, below=tuple(sub(*each) for each in below)), urn)


CHANGES: Final = st.lists(st.tuples(st.sampled_from("abcd"), _OFFERS, st.integers(0, 8)), max_size=24)
"""Which bus offers what, or nothing any more, and how many turns the event loop has then."""


async def change(changed: Engine, changes: list[tuple[str, Any, int]]) -> None:
    """Let buses come, change and go."""
    buses: dict[str, Bus] = {}
    for engine_id, shape_of, turns in changes:
        bus = buses.get(engine_id)
        if shape_of is None:
            if bus is not None:
                changed.detach(cast(ComponentBus, buses.pop(engine_id)))
        elif bus is None:
            streaming = (engine_id,) if shape_of[2] == "urn:b" else ()
            buses[engine_id] = Bus(_made(engine_id, *shape_of), streaming)
            await changed.attach(cast(ComponentBus, buses[engine_id]))
        else:
            bus.offered = _made(engine_id, *shape_of)
            await changed.refresh(cast(ComponentBus, bus))
        for _ in range(turns):
            await asyncio.sleep(0)
