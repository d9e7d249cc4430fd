"""An engine through the eyes of one principal: what it does not show cannot be reached either."""

import pytest

from openrois.auth.principal import Principal, Role
from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import NotResponding, TimedOut, Unsupported
from openrois.scope.scoped_engine import ScopedEngine
from openrois.scope.views import ViewChange, Views
from openrois.types.references import new_id
from openrois.types.streams import HolderNotification
from tests.support.components import Bell, Lamp
from tests.support.streams import Camera, FakeStreams

LAMP, BELL, HIDDEN = "robot/lamp", "robot/bell", "secret/lamp"
CLIENT = Client("c", lambda _method, _params: None)


def operator(*scope: str) -> Principal:
    return Principal("anna", frozenset({Role.OPERATOR}), scope)


@pytest.fixture
async def streams() -> FakeStreams:
    return FakeStreams("secret")


@pytest.fixture
async def engine(streams: FakeStreams) -> Engine:
    made = Engine("gateway")
    await made.attach(LocalRegistry("robot", [Lamp(), Bell()]))
    await made.attach(LocalRegistry("secret", [Lamp(), Camera()], extension=streams))
    return made


@pytest.fixture
def seen(engine: Engine) -> ScopedEngine:
    return ScopedEngine(engine, operator("robot/*"), Views(engine))


async def test_what_is_in_scope_is_reached(seen: ScopedEngine, engine: Engine) -> None:
    assert seen.require(LAMP).name == "lamp"
    assert [result.value for result in await seen.query(LAMP, "brightness")] == ["5"]
    assert [result.value for result in await seen.invoke(LAMP, "switch")] == ["1"]
    assert seen.leads_to(LAMP, seen.route(LAMP))
    assert seen.leads_alike(new_id("robot"), LAMP)
    assert (seen.engine_id, seen.tree.engine_ids) == ("gateway", {"gateway", "robot"})


@pytest.mark.parametrize("ref", [HIDDEN, "secret/camera", "secret/none", "none/lamp", "robot/none", "lamp", ""])
async def test_what_is_not_is_refused_with_the_words_for_what_is_not_there(seen: ScopedEngine, ref: str) -> None:
    words = f"there is no component {ref!r}"
    with pytest.raises(Unsupported, match=words):
        seen.require(ref)
    with pytest.raises(Unsupported, match=words):
        await seen.query(ref, "brightness")
    with pytest.raises(Unsupported, match=words):
        await seen.invoke(ref, "switch")
    with pytest.raises(Unsupported, match=words):
        await seen.extension.call("rois.stream.connect_stream", {"component_ref": ref}, CLIENT)
    with pytest.raises(Unsupported, match=words):
        await seen.extension.set_holder(HolderNotification(component_ref=ref, holds=True, epoch=1), CLIENT)


async def test_engines_and_what_they_mint(seen: ScopedEngine, engine: Engine, streams: FakeStreams) -> None:
    assert seen.extension.engines() == frozenset()
    for engine_id in ("secret", "none"):
        minted = new_id(engine_id)
        with pytest.raises(Unsupported, match=f"there is no engine for '{minted}'"):
            seen.route(minted)
        with pytest.raises(Unsupported, match=f"there is no engine for '{minted}'"):
            await seen.extension.call("rois.stream.suspend_stream", {"stream_id": minted}, CLIENT)
    assert streams.calls == []
    assert not seen.leads_to(HIDDEN, engine.route(HIDDEN))
    seen.principal = operator("*")
    assert seen.extension.engines() == {"secret"}
    connected = await seen.extension.call("rois.stream.connect_stream", {"component_ref": "secret/camera"}, CLIENT)
    await seen.extension.call("rois.stream.suspend_stream", {"stream_id": connected["stream_id"]}, CLIENT)
    seen.principal = operator()
    await seen.extension.forget_client(CLIENT)
    assert streams.forgotten == ["c"]


async def test_listeners_learn_whether_the_directory_is_different(seen: ScopedEngine, engine: Engine) -> None:
    heard: list[tuple[bool, frozenset[str]]] = []
    seen.on_change(lambda change: heard.append((change.visible, change.gone_refs)))
    more = LocalRegistry("more", [Lamp()])
    await engine.attach(more)
    assert heard == []
    seen.principal = operator("robot/*")
    assert heard == []
    seen.principal = operator("robot/*", "more/*")
    assert heard == [(True, frozenset())]
    engine.detach(more)
    assert heard == [(True, frozenset()), (True, frozenset({"more/lamp"}))]
    assert LAMP in seen.components
    seen.close()
    await engine.attach(more)
    assert len(heard) == 2


async def test_a_principal_that_sees_everything_is_notified_of_every_change(engine: Engine) -> None:
    everything = Principal("anna", frozenset({Role.ADMINISTRATOR}), ("*",))
    seen = ScopedEngine(engine, everything, Views(engine))
    heard: list[ViewChange] = []
    seen.on_change(heard.append)
    registry = LocalRegistry("idle", [])
    await engine.attach(registry)
    await engine.refresh(registry)
    assert [change.visible for change in heard] == [True, True]


async def test_what_only_the_audit_trail_may_know(seen: ScopedEngine) -> None:
    assert [seen.hides(ref) for ref in (HIDDEN, LAMP, "none/lamp")] == [True, False, False]
    assert [seen.sees(ref) for ref in (HIDDEN, LAMP, "robot/none")] == [False, True, True]


async def test_silence_is_blamed_on_the_component(seen: ScopedEngine, engine: Engine) -> None:
    faults: list[str] = []
    engine.faults.add(lambda together: faults.extend(fault.component_ref for fault in together))
    assert isinstance(seen.blame(LAMP, NotResponding("nothing came")), TimedOut)
    assert faults == [LAMP]
