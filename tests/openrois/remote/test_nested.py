"""A gateway behind another one: what changes behind the inner one is what the outer one reads."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, cast

import pytest
from hypothesis import given, settings

from openrois.aio.tasks import TaskScope
from openrois.contract import Client, ComponentBus, Event, SubscriptionLost
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Unsupported
from openrois.gateway.adapters import serve_adapter
from openrois.remote.serve import serve_engine
from openrois.session import change_notice
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from openrois.types.profiles import HRIEngineProfile, ParameterProfile, RoISIdentifier
from tests.support.components import Bell, Lamp
from tests.support.offers import CHANGES, Bus, attach, bodies, change, engine, offer, shape
from tests.support.streams import Camera, FakeStreams

PATIENCE = 30.0
CONNECT = "rois.stream.connect_stream"


@asynccontextmanager
async def nested(inner: Engine) -> AsyncIterator[tuple[EngineHost, list[str]]]:
    """Yield the host of an outer gateway behind which an inner one stands, and the methods that are asked there."""
    near, far = memory_pair(capacity=4096)
    asked: list[str] = []
    send = near.send

    async def noting(text: str) -> None:
        asked.append(text)
        await send(text)

    near.send = noting  # type: ignore[method-assign]
    async with TaskScope() as tasks:
        outer = EngineHost(Engine("outer"), tasks, sleep=lambda _seconds: asyncio.sleep(0))
        host = EngineHost(inner, tasks, sleep=lambda _seconds: asyncio.sleep(0))
        serving = [asyncio.ensure_future(serve_adapter(outer, near)), asyncio.ensure_future(serve_engine(host, far))]
        await until(outer, lambda: outer.engine.tree.has_engine(inner.engine_id))
        yield outer, asked
        await near.close()
        await asyncio.wait(serving, timeout=PATIENCE)


async def until(host: EngineHost, holds: Any) -> None:
    changed = asyncio.Event()
    stop = host.engine.on_change(changed.set)
    async with asyncio.timeout(PATIENCE):
        while not holds():
            changed.clear()
            await changed.wait()
    stop()


def behind(host: EngineHost, inner: Engine) -> Any:
    """Return what an outer gateway offers of an inner one, without the order of its engines."""
    whole = host.engine.tree.directory
    (below,) = whole.profile.sub_profiles
    return shape(below), {ref: whole.component_profiles[ref] for ref in below.component_ids}


def offered(inner: Engine) -> Any:
    """Return what an inner gateway offers itself."""
    whole = inner.tree.directory
    return shape(whole.profile), dict(whole.component_profiles)


async def test_all_that_its_profile_says_is_there() -> None:
    inner = Engine("inner")
    number = ParameterProfile(name="speed", data_type_ref=RoISIdentifier(code="integer"))
    robot = HRIEngineProfile(
        identifier=RoISIdentifier(code="robot", authority="maker", version="2"),
        component_ids=("robot/arm",),
        sub_profiles=(engine("hand", "finger"),),
        parameter_profiles=(number,),
    )
    await inner.attach(cast(ComponentBus, Bus(offer(robot))))
    await inner.attach(LocalRegistry("inner", [Bell()]))
    await inner.attach(LocalRegistry("eye", [Camera()], extension=FakeStreams("eye")))
    async with nested(inner) as (outer, _):
        assert behind(outer, inner) == offered(inner)
        assert outer.engine.extension.engines() == {"eye"}
        assert outer.engine.tree.directory.profile.sub_profiles[0].identifier.authority == "OpenRoIS"


async def test_the_role_of_an_application_reaches_engines_that_tell_visitors_apart_and_no_others() -> None:
    inner, eye, former = Engine("inner"), FakeStreams("eye"), FakeStreams("former")
    former.takes_role = False
    for streams in (eye, former):
        await inner.attach(LocalRegistry(streams.engine_id, [Camera()], extension=streams))
    async with nested(inner) as (outer, _):
        client = Client("ann", lambda _method, _params: None)
        params = {"parameters": [], "role": "visitor"}
        await outer.engine.extension.call(CONNECT, {**params, "component_ref": "eye/camera"}, client)
        assert eye.calls[0][1]["role"] == "visitor"
        with pytest.raises(Unsupported, match="its adapter is too old"):
            await outer.engine.extension.call(CONNECT, {**params, "component_ref": "former/camera"}, client)
        assert former.calls == []


async def test_one_change_behind_it_is_one_read() -> None:
    inner = Engine("inner")
    buses = await attach(inner, *bodies(300))
    async with nested(inner) as (outer, asked):
        asked.clear()
        buses[7].offered = offer(engine("body7", "arm"))
        await inner.refresh(cast(ComponentBus, buses[7]))
        await until(outer, lambda: "body7/eye" not in outer.engine.components)
        assert ["directory.read" in text for text in asked if "openrois.directory." in text] == [True]
        assert behind(outer, inner) == offered(inner)


async def test_a_subscription_is_made_anew_when_its_engine_was_away() -> None:
    inner, bell = Engine("inner"), Bell()
    registry, other = LocalRegistry("robot", [bell]), LocalRegistry("other", [Lamp()])
    await inner.attach(registry)
    await inner.attach(other)
    async with nested(inner) as (outer, _):
        heard = asyncio.Queue[Event | SubscriptionLost]()
        await outer.engine.subscribe("robot/bell", "rang", heard.put_nowait)
        changed = asyncio.Event()
        outer.engine.on_change(changed.set)
        async with asyncio.timeout(PATIENCE):
            inner.detach(registry)
            await inner.attach(registry)
            await changed.wait()
            await until(outer, lambda: "robot/bell" in outer.engine.components)
            await outer.engine.subscribe("robot/bell", "rang", heard.put_nowait)
            bell.ring("tune")
            while isinstance(await heard.get(), SubscriptionLost):
                pass


@given(CHANGES)
@settings(max_examples=60, deadline=None)
def test_after_any_changes_the_outer_gateway_has_what_the_inner_one_has(changes: Any) -> None:
    async def run() -> None:
        inner = Engine("inner")
        async with nested(inner) as (outer, _):
            await change(inner, changes)
            await until(outer, lambda: behind(outer, inner) == offered(inner))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(change_notice, "CHANGES_PER_SECOND", 1000)
        patch.setattr(change_notice, "MAX_CHANGED", 4)
        asyncio.run(run())
