"""A gateway's directory, followed over a connection: beside the real interfaces, and beside answers made up."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, cast

import pytest
from hypothesis import given, settings

from openrois.aio.tasks import TaskScope
from openrois.contract import ComponentBus
from openrois.engine.engine import MAX_DEPTH, Engine
from openrois.engine.profile_versions import profile_version
from openrois.errors import BadParameter, ComponentFailed, EngineUnreachable
from openrois.gateway.applications import serve_application
from openrois.interfaces import directory as directory_interface
from openrois.jsonrpc.protocol import Params
from openrois.jsonrpc.session import RpcSession
from openrois.remote import followed_engines, remote_directory
from openrois.remote.directory_follower import DirectoryFollower, FollowedEngine
from openrois.remote.rpc_call import RpcCalls
from openrois.session import change_notice
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from tests.support.offers import CHANGES, Bus, attach, bodies, change, component, engine, offer, shape

PATIENCE = 30.0


class CountedCalls(RpcCalls):
    """Counts what is asked."""

    def __init__(self, session: RpcSession) -> None:
        super().__init__(session)
        self.asked: Counter[str] = Counter()

    async def ask(self, name: str, params: Params, *args: Any, **named: Any) -> Any:
        self.asked[name.removeprefix("openrois.")] += 1
        return await super().ask(name, params, *args, **named)


class Followed:
    """What a follower says, and what follows from it."""

    def __init__(self, session: RpcSession) -> None:
        self.calls = CountedCalls(session)
        self.changes: list[Mapping[str, FollowedEngine | None]] = []
        self.engines: dict[str, FollowedEngine] = {}
        self.came = asyncio.Event()
        self.follower = DirectoryFollower(self.calls, self.note, lambda _seconds: asyncio.sleep(0))
        session.notifications = self.follower.notifications()

    def note(self, changes: Mapping[str, FollowedEngine | None]) -> None:
        self.changes.append(changes)
        for engine_id, followed in changes.items():
            if followed is None:
                del self.engines[engine_id]
            else:
                self.engines[engine_id] = followed
        self.came.set()

    async def until(self, holds: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE):
            while not holds():
                self.came.clear()
                await self.came.wait()


@asynccontextmanager
async def following(host: EngineHost) -> AsyncIterator[Followed]:
    near, far = memory_pair(capacity=4096)
    session = RpcSession(near)
    followed = Followed(session)
    async with TaskScope() as tasks:
        serving = asyncio.ensure_future(serve_application(host, far))
        running = asyncio.ensure_future(session.run())
        tasks.start(followed.follower.run())
        yield followed
        await near.close()
        await asyncio.wait({serving, running}, timeout=PATIENCE)


@asynccontextmanager
async def gateway() -> AsyncIterator[EngineHost]:
    async with TaskScope() as tasks:
        yield EngineHost(Engine("gateway"), tasks)


def there(host: EngineHost) -> dict[str, Any]:
    """Return what is behind a gateway."""
    whole, streaming = host.engine.tree.directory, host.engine.extension.engines()
    return {
        each.identifier.code: (
            shape(each),
            {ref: whole.component_profiles[ref] for ref in each.component_ids},
            streaming.intersection(each.engine_ids()),
        )
        for each in whole.profile.sub_profiles
    }


def seen(followed: Followed) -> dict[str, Any]:
    """Return what a follower has been told of."""
    return {
        engine_id: (shape(each.directory.profile), dict(each.directory.component_profiles), each.streaming)
        for engine_id, each in followed.engines.items()
    }


class TestFollowing:
    async def test_all_engines_come_first_with_those_below_them_and_their_streams(self) -> None:
        async with gateway() as host:
            deep = engine("robot", "arm", below=(engine("hand", "finger", below=(engine("nail"),)), engine("foot")))
            await host.engine.attach(cast(ComponentBus, Bus(offer(deep), ("hand",))))
            await attach(host.engine, *bodies(2), offer(engine("gateway", "clock")))
            async with following(host) as followed:
                await followed.until(lambda: bool(followed.changes))
                assert seen(followed) == there(host)
                assert list(followed.changes[0]) == ["body0", "body1", "robot"]
                assert followed.engines["robot"].streaming == {"hand"}

    async def test_without_engines_the_first_call_is_empty(self) -> None:
        async with gateway() as host, following(host) as followed:
            await followed.until(lambda: bool(followed.changes))
            assert followed.changes == [{}]

    async def test_pages_and_profiles_come_in_many_replies(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(directory_interface, "ITEMS", 3)
        monkeypatch.setattr(directory_interface, "ROOM", 1)
        async with gateway() as host:
            await attach(host.engine, *(offer(engine(f"body{n}", "arm", "eye"), f"urn:{n}") for n in range(7)))
            async with following(host) as followed:
                await followed.until(lambda: bool(followed.changes))
                assert seen(followed) == there(host)
                assert (followed.calls.asked["directory.list"], followed.calls.asked["directory.profiles"]) == (7, 14)

    async def test_one_changed_engine_of_a_thousand_costs_one_read(self) -> None:
        async with gateway() as host:
            buses = await attach(host.engine, *bodies(1000))
            async with following(host) as followed:
                await followed.until(lambda: len(followed.engines) == 1000)
                followed.calls.asked.clear()
                buses[500].offered = offer(engine("body500", "arm"))
                await host.engine.refresh(cast(ComponentBus, buses[500]))
                await followed.until(lambda: len(followed.changes) == 2)
                assert (list(followed.changes[1]), followed.calls.asked) == (["body500"], {"directory.read": 1})
                buses[7].offered = offer(engine("body7", "arm", "eye"), "urn:never seen")
                await host.engine.refresh(cast(ComponentBus, buses[7]))
                await followed.until(lambda: len(followed.changes) == 3)
                assert followed.calls.asked == {"directory.read": 2, "directory.profiles": 1}
                assert seen(followed) == there(host)

    async def test_profiles_that_are_known_already_are_not_read(self) -> None:
        async with gateway() as host:
            await attach(host.engine, *bodies(3))
            async with following(host) as one, following(host) as other:
                await one.until(lambda: bool(one.changes))
                await other.until(lambda: bool(other.changes))
                arms = {
                    each.directory.component_profiles["body0/arm"]
                    for each in (one.engines["body0"], other.engines["body0"])
                }
                assert len({id(arm) for arm in arms}) == 1
                assert one.calls.asked["directory.profiles"] + other.calls.asked["directory.profiles"] <= 2

    async def test_one_that_left_and_came_back_as_it_was_counts_as_another_one(self) -> None:
        async with gateway() as host:
            (bus,) = await attach(host.engine, *bodies(1))
            async with following(host) as followed:
                await followed.until(lambda: bool(followed.changes))
                host.engine.detach(cast(ComponentBus, bus))
                await host.engine.attach(cast(ComponentBus, bus))
                await followed.until(lambda: len(followed.changes) > 1 and bool(followed.engines))
                assert followed.changes[-1].keys() == {"body0"}

    async def test_changes_that_are_not_named_are_listed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(change_notice, "MAX_CHANGED", 2)
        monkeypatch.setattr(change_notice, "CHANGES_AT_ONCE", 1)
        monkeypatch.setattr(change_notice, "CHANGES_PER_SECOND", 20)
        async with gateway() as host:
            buses = await attach(host.engine, *bodies(8))
            async with following(host) as followed:
                await followed.until(lambda: bool(followed.changes))
                for bus in buses[:4]:
                    host.engine.detach(cast(ComponentBus, bus))
                await followed.until(lambda: len(followed.engines) == 4)
                assert followed.calls.asked["directory.list"] > 1
                assert seen(followed) == there(host)

    async def test_what_changes_all_the_time_holds_nothing_else_up(self) -> None:
        """The other engines are told of while one has changed again whenever it was read."""
        calm, busy = "calm", "busy"
        answers = Answers()
        answers.entries = {"main": entry("main", ""), calm: entry(calm), busy: entry(busy)}

        async def read(params: dict[str, Any]) -> dict[str, Any]:
            session.notify("openrois.directory.changed", {"changed": [busy], "gone": [], "unnamed": 0})
            return answers.read(params)

        async with made_up(answers) as (followed, session, _):
            session.methods = {**session.methods, "openrois.directory.read": read}
            await followed.until(lambda: bool(followed.changes))
            session.notify("openrois.directory.changed", {"changed": [busy], "gone": [], "unnamed": 0})
            answers.entries["more"] = entry("more")
            session.notify("openrois.directory.changed", {"changed": ["more"], "gone": [], "unnamed": 0})
            await followed.until(lambda: "more" in followed.engines)

    async def test_it_ends_with_the_connection(self) -> None:
        async with made_up(Answers()) as (followed, _, running):
            await followed.until(lambda: bool(followed.changes))
            followed.follower.lost("cut")
            with pytest.raises(EngineUnreachable, match="cut"):
                await running


@given(CHANGES)
@settings(max_examples=60, deadline=None)
def test_after_any_changes_what_is_followed_is_what_is_there(changes: list[tuple[str, Any, int]]) -> None:
    async def run() -> None:
        async with gateway() as host, following(host) as followed:
            await change(host.engine, changes)
            await followed.until(lambda: bool(followed.changes) and seen(followed) == there(host))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(change_notice, "CHANGES_PER_SECOND", 1000)
        patch.setattr(change_notice, "MAX_CHANGED", 4)
        asyncio.run(run())


def entry(engine_id: str, parent_id: str = "main", *refs: str, version: str = "") -> dict[str, Any]:
    """Return an entry as it is on the wire; its components have the profile `ARM`."""
    components = [
        {"component_ref": ref, "component_type": "urn:a", "function": None, "profile_version": version or ARM_VERSION}
        for ref in refs
    ]
    return {"engine_id": engine_id, "parent_id": parent_id, "version": "1", "extensions": [], "components": components}


ARM = component("arm", "urn:made up")
ARM_VERSION = profile_version(ARM).code


class Answers:
    """A directory that is made up."""

    def __init__(self, *more: dict[str, Any]) -> None:
        self.entries = {each["engine_id"]: each for each in (entry("main", ""), *more)}
        self.hello: dict[str, Any] = {"extensions": ["openrois.directory"], "of a newer version": 1}
        self.profiles: dict[str, Any] = {ARM_VERSION: ARM.model_dump(mode="json")}
        self.left: list[str] = []

    def list(self, params: dict[str, Any]) -> dict[str, Any]:
        after = params["after"]
        return {"return_code": "OK", "engines": [self.entries[each] for each in sorted(self.entries) if each > after]}

    def read(self, params: dict[str, Any]) -> dict[str, Any]:
        asked = params["engine_ids"]
        return {"return_code": "OK", "engines": [self.entries[each] for each in asked if each in self.entries]}

    def read_profiles(self, _params: dict[str, Any]) -> dict[str, Any]:
        return {"return_code": "OK", "profiles": self.profiles, "left": self.left}


@asynccontextmanager
async def made_up(answers: Answers) -> AsyncIterator[tuple[Followed, RpcSession, asyncio.Future[None]]]:
    """Yield what follows made-up answers, the session that gives them, and what the follower runs in."""
    near, far = memory_pair(capacity=4096)

    def answering(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[dict[str, Any]], Any]:
        async def handle(params: dict[str, Any]) -> dict[str, Any]:
            return answer(params)

        return handle

    session, serving = RpcSession(near), RpcSession(far)
    serving.methods = {
        "openrois.hello": answering(lambda _params: {"return_code": "OK", **answers.hello}),
        "openrois.directory.list": answering(lambda params: answers.list(params)),
        "openrois.directory.read": answering(lambda params: answers.read(params)),
        "openrois.directory.profiles": answering(lambda params: answers.read_profiles(params)),
    }
    followed = Followed(session)
    sessions = [asyncio.ensure_future(each.run()) for each in (session, serving)]
    running = asyncio.ensure_future(followed.follower.run())
    try:
        yield followed, serving, running
    finally:
        running.cancel()
        await near.close()
        await asyncio.wait({running, *sessions}, timeout=PATIENCE)


async def failure(answers: Answers) -> str:
    """Return why a directory that is made up cannot be followed."""
    async with made_up(answers) as (_, _, running), asyncio.timeout(PATIENCE):
        with pytest.raises((BadParameter, ComponentFailed)) as caught:
            await running
    return str(caught.value)


class TestHostile:
    @pytest.mark.parametrize(
        ("entries", "why"),
        [
            ([entry("a", "absent")], "below an unknown one"),
            ([entry("a", "b"), entry("b", "a")], "below itself"),
            ([entry("a", "a")], "below itself"),
            ([entry("a", "")], "a main engine besides"),
            ([entry("a/b")], "it has a slash"),
            ([entry("a", "x" * 129)], "it has more than 128 characters"),
            ([entry("a", "main", "a/arm", "a/arm")], "it stands twice"),
            ([entry("a", "main", "arm")], "it is empty"),
            ([entry("a", "main", "a/" + "x" * 129)], "it has more than 128 characters"),
            ([entry("a", "main", "b/arm"), entry("b")], "belongs to no engine here"),
            ([entry("a", "main", "b/arm"), entry("b", "a", "b/arm")], "stands twice"),
            ([entry("a", "main", "a/arm", version="v" * 65)], "needs a version of 1 to 64"),
            ([entry("a", "main", "a/arm", version="other")], "does not give the profile of 'a/arm'"),
            ([entry(f"e{n}", f"e{n - 1}" if n else "main") for n in range(MAX_DEPTH)], "nested 8 deep at most"),
            ([entry(f"e{n}", f"e{n + 1}" if n < 30 else "main") for n in range(31)], "nested too deep"),
            ([{"engine_id": "a"}], "malformed"),
        ],
    )
    async def test_entries_that_are_no_tree(self, entries: list[dict[str, Any]], why: str) -> None:
        assert why in await failure(Answers(*entries))

    async def test_engines_as_deep_as_they_may_be(self) -> None:
        depth = MAX_DEPTH - 1
        answers = Answers(*(entry(f"e{n}", f"e{n - 1}" if n else "main") for n in range(depth)))
        async with made_up(answers) as (followed, _, _):
            await followed.until(lambda: bool(followed.changes))
            assert len(followed.engines["e0"].directory.profile.engine_ids()) == depth

    @pytest.mark.parametrize(
        ("page", "why"),
        [
            ({"engines": [entry("b"), entry("a")]}, "not in the order"),
            ({"engines": [entry("a"), entry("a")]}, "not in the order"),
            ({"engines": [], "next": "a"}, "do not go on"),
            ({"engines": [entry("b")], "next": "a"}, "do not go on"),
            ({"engines": [entry("a"), entry("main", "")], "next": "main"}, "not in the order"),
            ({"engines": [entry("a")]}, "no main engine"),
            ({"engines": []}, "no main engine"),
        ],
    )
    async def test_pages_that_are_none(self, page: dict[str, Any], why: str) -> None:
        answers = Answers()
        answers.list = lambda params: {"return_code": "OK", **page}  # type: ignore[method-assign]
        assert why in await failure(answers)

    @pytest.mark.parametrize(
        ("profiles", "left", "why"),
        [
            ({"new": component("leg").model_dump(mode="json")}, [], "has not the version"),
            ({}, ["a/arm"], "with other components"),
            ({}, ["b/arm"], "with other components"),
            ({"new": {"name": "arm"}}, [], "malformed"),
        ],
    )
    async def test_profiles_that_are_others(self, profiles: dict[str, Any], left: list[str], why: str) -> None:
        answers = Answers(entry("a", "main", "a/arm", version="new"))
        answers.profiles, answers.left = profiles, left
        assert why in await failure(answers)

    @pytest.mark.parametrize(
        "result", [{"engines": [entry("b")]}, {"engines": [entry("a"), entry("a")]}, {"left": ["a"]}, {"left": "a"}]
    )
    async def test_a_reply_about_other_engines_than_asked_for(self, result: dict[str, Any]) -> None:
        answers = Answers(entry("a"))
        answers.read = lambda params: {"return_code": "OK", **result}  # type: ignore[method-assign]
        async with made_up(answers) as (followed, session, running), asyncio.timeout(PATIENCE):
            await followed.until(lambda: bool(followed.changes))
            session.notify("openrois.directory.changed", {"changed": ["a"], "gone": [], "unnamed": 0})
            with pytest.raises(ComponentFailed, match="answer"):
                await running

    async def test_the_main_engine_cannot_go(self) -> None:
        async with made_up(Answers()) as (followed, session, running), asyncio.timeout(PATIENCE):
            await followed.until(lambda: bool(followed.changes))
            session.notify("openrois.directory.changed", {"changed": [], "gone": ["main"], "unnamed": 0})
            with pytest.raises(ComponentFailed, match="no main engine"):
                await running

    async def test_a_gateway_without_the_extension(self) -> None:
        answers = Answers()
        answers.hello = {}
        assert "too old to be followed" in await failure(answers)

    @pytest.mark.parametrize("limit", ["MAX_ENGINES", "MAX_COMPONENTS", "MAX_TEXT"])
    async def test_a_directory_is_bounded(self, limit: str, monkeypatch: pytest.MonkeyPatch) -> None:
        size = {"MAX_ENGINES": 2, "MAX_COMPONENTS": 1, "MAX_TEXT": profile_version(ARM).size}[limit]
        answers = Answers(entry("a", "main", "a/arm"))
        monkeypatch.setattr(followed_engines, limit, size)
        async with made_up(answers) as (followed, _, _):
            await followed.until(lambda: "a" in followed.engines)
        monkeypatch.setattr(followed_engines, limit, size - 1)
        assert "at most" in await failure(answers)

    async def test_of_more_changes_than_may_wait_all_are_listed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(remote_directory, "MAX_STALE", 3)
        answers = Answers(entry("a"))
        async with made_up(answers) as (followed, session, _):
            await followed.until(lambda: bool(followed.changes))
            session.notify("openrois.directory.changed", {"changed": ["a", "b/", "c", "d"], "gone": [], "unnamed": 0})
            await followed.until(lambda: len(followed.changes) == 2)
            assert (followed.calls.asked["directory.list"], followed.calls.asked["directory.read"]) == (1, 1)
            session.notify("openrois.directory.changed", {"changed": ["a", "b", "c", "d"], "gone": [], "unnamed": 0})
            await followed.until(lambda: len(followed.changes) == 3)
            assert (followed.calls.asked["directory.list"], followed.calls.asked["directory.read"]) == (2, 1)

    async def test_many_notifications_while_one_read_runs_share_the_next_one(self) -> None:
        answers = Answers(entry("a"), entry("b"))
        may_answer = asyncio.Event()

        async with made_up(answers) as (followed, session, _):
            await followed.until(lambda: bool(followed.changes))

            async def read(params: dict[str, Any]) -> dict[str, Any]:
                await may_answer.wait()
                return answers.read(params)

            session.methods = {**session.methods, "openrois.directory.read": read}
            for number in range(100):
                session.notify("openrois.directory.changed", {"changed": ["a", "b"][: number % 2 + 1]})
                await asyncio.sleep(0)
            may_answer.set()
            await followed.until(lambda: any("b" in changes for changes in followed.changes[1:]))
            assert followed.calls.asked["directory.read"] == 2

    async def test_a_profile_that_has_changed_meanwhile_is_that_of_another_entry(self) -> None:
        """Between entry and profile the component changes: the entry is read again."""
        answers = Answers(entry("a", "main", "a/arm", version="former"))
        leg = component("leg")

        def read_profiles(_params: dict[str, Any]) -> dict[str, Any]:
            answers.entries["a"] = entry("a", "main", "a/arm", version=profile_version(leg).code)
            return {"return_code": "OK", "profiles": {profile_version(leg).code: leg.model_dump(mode="json")}}

        answers.read_profiles = read_profiles  # type: ignore[method-assign]
        async with made_up(answers) as (followed, _, _):
            await followed.until(lambda: "a" in followed.engines)
            assert followed.engines["a"].directory.component_profiles == {"a/arm": leg}
