"""Attaching, routing and what is refused. What every bus does is in `tests/contract`."""

import logging
from collections.abc import Mapping
from typing import Any

import pytest

from openrois.contract import Client, Directory, Sink
from openrois.engine.engine import MAX_DEPTH, Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter, EngineUnreachable, Unsupported
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier
from openrois.types.streams import HolderNotification
from tests.support.components import Bell, Lamp

LAMP = HRIComponentProfile(identifier=RoISIdentifier(code="urn:lamp"), name="lamp")


def tree(engine_id: str, *below: HRIEngineProfile, refs: tuple[str, ...] = ()) -> HRIEngineProfile:
    return HRIEngineProfile(identifier=RoISIdentifier(code=engine_id), sub_profiles=below, component_ids=refs)


class Far:
    """A bus that says whatever the test wants and notes what it was asked."""

    def __init__(self, profile: HRIEngineProfile, **profiles: HRIComponentProfile) -> None:
        self.directory = Directory(profile, dict.fromkeys(profile.component_refs(), LAMP) | profiles)
        self.extension: FarExtension | None = None
        self.asked: list[str] = []
        self.reachable = True

    async def discover(self) -> Directory:
        if not self.reachable:
            raise EngineUnreachable("gone")
        return self.directory

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        self.asked.append(f"query {query_type} of {component_ref}")
        return ()

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        self.asked.append(f"invoke {command_type} of {component_ref}")
        return ()

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        self.asked.append(f"subscribe {event_type} of {component_ref}")
        return "an id"

    async def unsubscribe(self, subscribe_id: str) -> None:
        self.asked.append(f"unsubscribe {subscribe_id}")


class FarExtension:
    def __init__(self, *engines: str, broken: bool = False) -> None:
        self.reach = frozenset(engines)
        self.takes_role = False
        self.calls: list[tuple[str, str]] = []
        self.forgotten: list[str] = []
        self.broken = broken

    def engines(self) -> frozenset[str]:
        return self.reach

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        self.calls.append((method, client.client_id))
        return {"return_code": "OK"}

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        self.calls.append((notification.method, client.client_id))

    async def forget_client(self, client: Client) -> None:
        if self.broken:
            raise EngineUnreachable("gone")
        self.forgotten.append(client.client_id)


@pytest.fixture
def engine() -> Engine:
    return Engine("gateway")


def changes(engine: Engine) -> list[tuple[str, ...]]:
    """Return a list that gets the engine ids after each change."""
    seen: list[tuple[str, ...]] = []
    engine.on_change(lambda: seen.append(engine.directory.profile.engine_ids()))
    return seen


@pytest.mark.parametrize("engine_id", ["", "a/b"])
def test_an_engine_needs_an_id(engine_id: str) -> None:
    with pytest.raises(BadParameter):
        Engine(engine_id)


class TestAttach:
    async def test_references_and_ids_stay_as_they_are(self, engine: Engine) -> None:
        seen = changes(engine)
        await engine.attach(LocalRegistry("gateway", [Bell()]))
        await engine.attach(Far(tree("fleet", tree("a", refs=("a/lamp",)))))
        directory = await engine.discover()
        assert directory.profile.engine_ids() == ("gateway", "fleet", "a")
        assert directory.profile.component_ids == ("gateway/bell", "a/lamp")
        assert list(directory.component_profiles) == ["gateway/bell", "a/lamp"]
        assert seen == [("gateway",), ("gateway", "fleet", "a")]

    @pytest.mark.parametrize(
        "profile",
        [
            tree(""),
            tree("x/y"),
            tree("x" * 129),
            tree("a"),
            tree("b", tree("a")),
            tree("b", tree("c"), tree("c")),
            tree("b", tree("b")),
            tree("b", tree("gateway")),
            tree("gateway", tree("b")),
            tree("b", refs=("a/lamp",)),
            tree("b", refs=("lamp",)),
            tree("b", refs=("bb/lamp",)),
            tree("b", refs=("b",)),
            tree("b", refs=("b/",)),
            tree("b", refs=("b/a/lamp",)),
            tree("b", refs=("b/" + "x" * 129,)),
            tree("b", refs=("b/lamp\n",)),
            tree("b", refs=("b/lamp", "b/lamp")),
        ],
        ids=repr,
    )
    async def test_what_does_not_belong_into_the_tree(self, engine: Engine, profile: HRIEngineProfile) -> None:
        await engine.attach(Far(tree("a", refs=("a/lamp",))))
        seen = changes(engine)
        with pytest.raises(BadParameter):
            await engine.attach(Far(profile))
        assert seen == []
        assert engine.directory.profile.engine_ids() == ("gateway", "a")

    async def test_a_component_without_a_profile(self, engine: Engine) -> None:
        far = Far(tree("a", refs=("a/lamp",)))
        far.directory = Directory(far.directory.profile)
        with pytest.raises(BadParameter, match="a/lamp"):
            await engine.attach(far)

    async def test_a_profile_of_a_component_that_is_not_offered_changes_nothing(self, engine: Engine) -> None:
        await engine.attach(LocalRegistry("a", [Lamp()]))
        evil = LAMP.model_copy(update={"name": "evil"})
        await engine.attach(Far(tree("b", refs=("b/lamp",)), **{"a/lamp": evil, "b/hidden": evil}))
        assert engine.directory.component_profiles["a/lamp"].name == "lamp"
        assert set(engine.directory.component_profiles) == {"a/lamp", "b/lamp"}

    async def test_engines_stand_only_so_deep(self, engine: Engine) -> None:
        def chain(length: int) -> HRIEngineProfile:
            profile = tree(f"e{length}")
            for number in range(1, length):
                profile = tree(f"e{length}-{number}", profile)
            return profile

        await engine.attach(Far(chain(MAX_DEPTH - 1)))
        with pytest.raises(BadParameter, match="deep"):
            await engine.attach(Far(chain(MAX_DEPTH)))

    async def test_an_engine_is_not_below_itself(self, engine: Engine) -> None:
        with pytest.raises(BadParameter):
            await engine.attach(engine)
        other = Engine("other")
        await engine.attach(other)
        for upper, lower in ((engine, engine), (other, engine)):
            with pytest.raises(BadParameter):
                await upper.attach(lower)

    async def test_own_components_come_from_one_bus_of_this_process(self, engine: Engine) -> None:
        with pytest.raises(BadParameter):
            await engine.attach(Far(tree("gateway", refs=("gateway/x",))), own=False)
        await engine.attach(LocalRegistry("gateway", [Bell()]))
        with pytest.raises(BadParameter):
            await engine.attach(LocalRegistry("gateway", [Lamp()]))

    async def test_what_cannot_be_asked_is_not_attached(self, engine: Engine) -> None:
        far = Far(tree("a"))
        far.reachable = False
        with pytest.raises(EngineUnreachable):
            await engine.attach(far)
        assert engine.directory.profile.engine_ids() == ("gateway",)


class TestRefresh:
    async def test_a_new_profile_takes_the_place_of_the_old(self, engine: Engine) -> None:
        far = Far(tree("a", refs=("a/lamp",)))
        await engine.attach(far)
        seen = changes(engine)
        far.directory = Directory(tree("a", tree("below")))
        await engine.refresh(far)
        assert seen == [("gateway", "a", "below")]
        assert not engine.directory.component_profiles

    async def test_one_that_is_not_acceptable_leaves_the_old(self, engine: Engine) -> None:
        far = Far(tree("a"))
        await engine.attach(far, own=False)
        await engine.attach(Far(tree("b")))
        for profile in (tree("a", tree("b")), tree("gateway")):
            far.directory = Directory(profile)
            with pytest.raises(BadParameter):
                await engine.refresh(far)
        assert engine.directory.profile.engine_ids() == ("gateway", "a", "b")

    async def test_a_bus_that_is_not_attached_is_ignored(self, engine: Engine) -> None:
        seen = changes(engine)
        await engine.refresh(Far(tree("a")))
        engine.detach(Far(tree("a")))
        assert seen == []


class TestDetach:
    async def test_what_it_offered_is_gone(self, engine: Engine) -> None:
        far = Far(tree("a", refs=("a/lamp",)))
        await engine.attach(far)
        await engine.subscribe("a/lamp", "switched", lambda _item: None)
        seen = changes(engine)
        engine.detach(far)
        assert seen == [("gateway",)]
        for name in ("a/lamp", "a/"):
            with pytest.raises(Unsupported):
                engine.route(name)
        await engine.unsubscribe("an id")
        assert far.asked == ["subscribe switched of a/lamp"]
        await engine.attach(Far(tree("a")))

    async def test_subscriptions_of_others_stay(self, engine: Engine) -> None:
        bell, far = Bell(), Far(tree("a"))
        await engine.attach(LocalRegistry("b", [bell]))
        await engine.attach(far)
        heard: list[Any] = []
        subscribe_id = await engine.subscribe("b/bell", "rang", heard.append)
        engine.detach(far)
        bell.ring("ding")
        await engine.unsubscribe(subscribe_id)
        bell.ring("ding")
        assert len(heard) == 1


class TestListeners:
    async def test_a_listener_may_leave_more_than_once_and_while_it_is_told(self, engine: Engine) -> None:
        seen: list[str] = []

        def once() -> None:
            seen.append("once")
            leave()
            leave()

        leave = engine.on_change(once)
        engine.on_change(lambda: seen.append("always"))
        for engine_id in "ab":
            await engine.attach(Far(tree(engine_id)))
        assert seen == ["once", "always", "always"]

    async def test_the_same_listener_twice_is_two(self, engine: Engine) -> None:
        seen: list[str] = []

        def listener() -> None:
            seen.append("told")

        leave, _ = engine.on_change(listener), engine.on_change(listener)
        leave()
        await engine.attach(Far(tree("a")))
        assert seen == ["told"]


class TestRouting:
    async def test_the_five_methods_go_where_the_engine_id_leads(self, engine: Engine) -> None:
        a, b = Far(tree("a", tree("below"))), Far(tree("b"))
        await engine.attach(a)
        await engine.attach(b)
        await engine.query("below/lamp", "q")
        await engine.invoke("a/lamp", "c")
        await engine.subscribe("b/lamp", "e", lambda _item: None)
        await engine.unsubscribe("an id")
        await engine.unsubscribe("an id")
        assert a.asked == ["query q of below/lamp", "invoke c of a/lamp"]
        assert b.asked == ["subscribe e of b/lamp", "unsubscribe an id"]

    async def test_a_subscription_to_a_component_that_went_is_forgotten(self, engine: Engine) -> None:
        """The bus has notified its sink already; what is noted here may not grow with every coming and going."""
        far = Far(tree("a", refs=("a/lamp", "a/bell")))
        await engine.attach(far)
        await engine.subscribe("a/lamp", "e", lambda _item: None)
        far.directory = Directory(tree("a", refs=("a/bell",)), {"a/bell": LAMP})
        await engine.refresh(far)
        await engine.unsubscribe("an id")
        assert far.asked == ["subscribe e of a/lamp"]

    @pytest.mark.parametrize("ref", ["", "a", "/lamp", "absent/lamp", "x" * 1000])
    async def test_a_reference_that_leads_nowhere(self, engine: Engine, ref: str) -> None:
        await engine.attach(Far(tree("a")))
        with pytest.raises(Unsupported) as raised:
            await engine.query(ref, "q")
        assert len(str(raised.value)) < 300


class TestExtension:
    async def test_calls_go_where_their_id_leads(self, engine: Engine) -> None:
        a, b = Far(tree("a")), Far(tree("b"))
        a.extension, b.extension = FarExtension("a"), FarExtension("b")
        client = Client("me", lambda _method, _params: None)
        for bus in (a, b):
            await engine.attach(bus)
        for key in ("component_ref", "stream_id", "peer_id"):
            await engine.extension.call(key, {key: "a/1"}, client)
        await engine.extension.call("x", {"stream_id": "b/1"}, client)
        assert [method for method, _ in a.extension.calls] == ["component_ref", "stream_id", "peer_id"]
        assert b.extension.calls == [("x", "me")]

    @pytest.mark.parametrize("params", [{}, {"stream_id": 5}, {"stream_id": "absent/1"}, {"stream_id": "a/1"}])
    async def test_a_call_that_leads_nowhere_or_to_an_engine_without_streams(
        self, engine: Engine, params: dict[str, Any]
    ) -> None:
        await engine.attach(Far(tree("a")))
        with pytest.raises(Unsupported):
            await engine.extension.call("x", params, Client("me", lambda _method, _params: None))

    async def test_an_engine_that_tells_no_visitors_apart_is_asked_nothing_that_needs_it(self, engine: Engine) -> None:
        far, client = Far(tree("a")), Client("me", lambda _method, _params: None)
        far.extension = FarExtension("a")
        await engine.attach(far)
        params = {"component_ref": "a/camera", "role": "visitor"}
        with pytest.raises(Unsupported, match="its adapter is too old"):
            await engine.extension.call("x", params, client)
        assert far.extension.calls == []
        far.extension.takes_role = True
        await engine.extension.call("x", params, client)
        assert far.extension.calls == [("x", "me")]

    async def test_a_holder_is_notified_to_the_engine_of_the_component_also_without_streams(
        self, engine: Engine
    ) -> None:
        a, b = Far(tree("a")), Far(tree("b"))
        a.extension = FarExtension()
        client = Client("me", lambda _method, _params: None)
        for bus in (a, b):
            await engine.attach(bus)
        await engine.extension.set_holder(HolderNotification(component_ref="a/x", holds=True, epoch=1), client)
        assert a.extension.calls == [("openrois.holder", "me")]
        for ref in ("b/x", "absent/x"):
            with pytest.raises(Unsupported):
                await engine.extension.set_holder(HolderNotification(component_ref=ref, holds=True, epoch=1), client)

    async def test_every_bus_learns_that_a_client_is_gone(
        self, engine: Engine, caplog: pytest.LogCaptureFixture
    ) -> None:
        buses = [Far(tree(name)) for name in "abcd"]
        extensions = [FarExtension("a", broken=True), FarExtension("b"), FarExtension("c"), FarExtension("d")]
        client = Client("me", lambda _method, _params: None)
        for bus, extension in zip(buses, extensions, strict=True):
            bus.extension = extension
            await engine.attach(bus)
        await engine.extension.call("rois.stream.suspend_stream", {"stream_id": "a/1"}, client)
        await engine.extension.call("rois.stream.suspend_stream", {"stream_id": "b/1"}, client)
        await engine.extension.set_holder(HolderNotification(component_ref="c/x", holds=True, epoch=1), client)
        with caplog.at_level(logging.INFO):
            await engine.extension.forget_client(client)
            await engine.extension.forget_client(client)
        assert [each.forgotten for each in extensions] == [[], ["me"], ["me"], []]
        assert "could not end what a departed client has" in caplog.text

    async def test_which_engines_have_it(self, engine: Engine) -> None:
        a, b = Far(tree("a", tree("a1"))), Far(tree("b", tree("b1")))
        a.extension = FarExtension("a1")
        middle = Engine("middle")
        await middle.attach(b)
        for bus in (a, middle, LocalRegistry("c", [])):
            await engine.attach(bus)
        assert engine.extension.engines() == {"a1"}
        client = Client("me", lambda _method, _params: None)
        for ref in ("a/x", "b1/x", "c/x"):
            with pytest.raises(Unsupported):
                await engine.extension.call("x", {"component_ref": ref}, client)
        b.extension = FarExtension("b1")
        assert engine.extension.engines() == {"a1", "b1"}
        await engine.extension.call("x", {"component_ref": "b1/x"}, client)
        assert b.extension.calls == [("x", "me")]
