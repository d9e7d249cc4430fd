"""The directory as a client knows it: read once, in pages, and then only what has changed."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from openrois.client import Client, ProfileChanged
from openrois.client.body_directory import bodies_in, bodies_of
from openrois.client.engine_directory import MAX_COUNTED, EngineDirectory, Generations
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.types.directory import DirectoryChangedNotification, DirectoryListResult, DirectoryReadResult, EngineEntry
from tests.support.components import Bell, Lamp
from tests.support.grounds import Line, heard


def entry(engine_id: str, version: str = "1") -> EngineEntry:
    return EngineEntry(engine_id=engine_id, parent_id="gateway", version=version)


class Gateway:
    """Answers about a directory, two engines to a page; what it does before an answer is up to the test."""

    def __init__(self, *engine_ids: str) -> None:
        self.entries = {engine_id: entry(engine_id) for engine_id in engine_ids}
        self.asked: list[tuple[str, Any]] = []
        self.before_answer: list[Callable[[], None]] = []

    async def ask(self, method: str, params: Any, _model: Any, accepted: Any = None, _too_late: Any = None) -> Any:
        await asyncio.sleep(0)
        if self.before_answer:
            self.before_answer.pop(0)()
        if method == "openrois.directory.list":
            self.asked.append(("list", params.after))
            behind = sorted(engine_id for engine_id in self.entries if engine_id > params.after)
            page = tuple(self.entries[engine_id] for engine_id in behind[:2])
            result: Any = DirectoryListResult(engines=page, next=behind[1] if len(behind) > 2 else "")
        else:
            self.asked.append(("read", tuple(sorted(params.engine_ids))))
            some = [engine_id for engine_id in params.engine_ids if engine_id in self.entries]
            left = tuple(some[2:])
            result = DirectoryReadResult(engines=tuple(self.entries[each] for each in some[:2]), left=left)
        accepted(result)
        return result


@pytest.fixture
def gateway() -> Gateway:
    return Gateway("a", "b", "c")


@pytest.fixture
def directory(gateway: Gateway) -> EngineDirectory:
    return EngineDirectory(lambda: gateway)  # type: ignore[arg-type, return-value]


def changed(*engine_ids: str, gone: tuple[str, ...] = (), unnamed: int = 0) -> DirectoryChangedNotification:
    return DirectoryChangedNotification(changed=engine_ids, gone=gone, unnamed=unnamed)


async def test_it_is_listed_once_and_then_only_asked_whether_anything_has_changed(
    gateway: Gateway, directory: EngineDirectory
) -> None:
    assert await directory.read() == gateway.entries
    assert await directory.read() == gateway.entries
    assert gateway.asked == [("list", ""), ("list", "b"), ("read", ())]


async def test_pages_that_do_not_go_on_are_the_last(gateway: Gateway, directory: EngineDirectory) -> None:
    ask = gateway.ask

    async def go_round(method: str, params: Any, model: Any, accepted: Any = None, too_late: Any = None) -> Any:
        result = await ask(method, params, model, accepted, too_late)
        return result.model_copy(update={"next": "b"}) if method == "openrois.directory.list" else result

    gateway.ask = go_round  # type: ignore[assignment, method-assign]
    assert await directory.read() == gateway.entries
    assert gateway.asked == [("list", ""), ("list", "b")]


async def test_only_what_has_changed_is_read(gateway: Gateway, directory: EngineDirectory) -> None:
    await directory.read()
    gateway.asked.clear()
    for engine_id in ("a", "b", "d"):
        gateway.entries[engine_id] = entry(engine_id, "2")
    del gateway.entries["c"]
    directory.note_changes(changed("a", "b", "c", "d"))
    directory.note_changes(changed(gone=("c",)))
    assert await directory.read() == gateway.entries
    assert gateway.asked == [("read", ("a", "b", "d")), ("read", ("d",))]


async def test_what_is_told_before_a_reply_is_read_too(gateway: Gateway, directory: EngineDirectory) -> None:
    await directory.read()
    gateway.asked.clear()

    def come() -> None:
        gateway.entries["d"] = entry("d")
        directory.note_changes(changed("d"))

    gateway.before_answer = [come]
    assert await directory.read() == gateway.entries
    assert gateway.asked == [("read", ()), ("read", ("d",))]


async def test_changes_while_it_is_listed_count(gateway: Gateway, directory: EngineDirectory) -> None:
    def change() -> None:
        del gateway.entries["a"]
        gateway.entries["c"] = entry("c", "2")
        directory.note_changes(changed("c", gone=("a",)))

    gateway.before_answer = [lambda: None, change]
    assert await directory.read() == gateway.entries


@pytest.mark.parametrize("again", ["too much", "another connection"])
async def test_it_is_listed_again(gateway: Gateway, directory: EngineDirectory, again: str) -> None:
    await directory.read()

    def lose() -> None:
        gateway.entries = {engine_id: entry(engine_id) for engine_id in ("x", "y", "z")}
        if again == "too much":
            directory.note_changes(changed("x", unnamed=1))
        else:
            directory.reset()

    lose()
    assert await directory.read() == gateway.entries
    directory.reset()
    gateway.before_answer = [lambda: None, lose]
    assert await directory.read() == gateway.entries


def test_a_count_of_changes_never_returns_to_a_former_one() -> None:
    generations = Generations()
    seen = [generations.of("a")]
    for engine_ids in (["a", "b"], None, [f"engine-{number}" for number in range(MAX_COUNTED + 1)], ["a"]):
        if engine_ids is None:
            generations.count_all()
        else:
            generations.count(engine_ids)
        seen.append(generations.of("a"))
    assert len(set(seen)) == len(seen)
    before = generations.of("b")
    generations.count(("a",))
    assert generations.of("b") == before
    assert generations.total == 6


@pytest.fixture
async def nested() -> Engine:
    """An engine of the gateway's own, a robot with an arm that is an engine, and a site that owns nothing."""
    main, robot, site = Engine("gateway"), Engine("robot"), Engine("site")
    await main.attach(LocalRegistry("gateway", [Bell()]))
    await robot.attach(LocalRegistry("robot", [Bell()]))
    await robot.attach(LocalRegistry("arm", [Lamp()]))
    await site.attach(LocalRegistry("b", [Lamp()]))
    await site.attach(LocalRegistry("a", [Lamp(), Bell()]))
    for engine in (site, robot):
        await main.attach(engine)
    return main


async def test_bodies_are_the_same_by_directory_and_by_profile(line: Line, nested: Engine) -> None:
    line.host.engine = nested
    line.host.views = type(line.host.views)(nested)
    async with Client(dial=line.dial) as client:
        by_profile = bodies_in(await client.get_profile())
        entries = await client._application.directory.read()
        assert bodies_of(entries.values()) == by_profile
        assert [body.engine_id for body in by_profile] == ["arm", "robot", "a", "b", "gateway"]
        robot = next(body for body in by_profile if body.engine_id == "robot")
        assert list(robot.types) == ["arm/lamp", "robot/bell"]


async def test_a_client_learns_which_engines_have_changed(line: Line) -> None:
    async with Client(dial=line.dial) as client:
        notices = client.notices(ProfileChanged)
        bell = client.component("toys/bell")
        profile = await bell._shape()
        more = LocalRegistry("more", [Lamp()])
        await line.host.engine.attach(more)
        (told,) = await heard(notices, ProfileChanged)
        assert isinstance(told, ProfileChanged)
        assert told.engine_ids == {"more"}
        assert await bell._shape() is profile
        assert {body.engine_id for body in await client.bodies()} == {"more", "robot", "toys"}
        line.host.engine.detach(more)
        assert {body.engine_id for body in await client.bodies()} == {"robot", "toys"}
        line.host.engine.detach(line.toys)
        await heard(notices, ProfileChanged, ProfileChanged)
        await line.host.engine.attach(line.toys)
        await heard(notices, ProfileChanged)
        assert await bell._shape() is not profile
