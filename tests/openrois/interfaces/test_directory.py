"""The directory in pages: what it shows, its versions, and its bounds."""

from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces import directory
from openrois.session.session import EngineHost
from openrois.types.directory import MAX_PAGE, MAX_PROFILES
from tests.support.authorization import Place, principal
from tests.support.components import Bell, Lamp
from tests.support.streams import Camera, FakeStreams

IDS = ["a", "b", "c", "gateway"]
EVERYTHING = principal("viewer", "*")


@pytest.fixture
async def place() -> AsyncIterator[Place]:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("c", [Lamp(), Bell()]))
    await engine.attach(LocalRegistry("a", [Lamp()]))
    await engine.attach(LocalRegistry("b", [Camera()], extension=FakeStreams("b")))
    async with TaskScope() as tasks:
        yield Place(EngineHost(engine, tasks), {})


async def pages(place: Place, who: Principal | TokenExpiry = EVERYTHING, **params: Any) -> list[dict[str, Any]]:
    """Return all pages."""
    found = []
    async with place.application(who) as app:
        after = ""
        while True:
            page = await app.result("openrois.directory.list", {"after": after, **params})
            found.append(page)
            after = page["next"]
            if not after:
                return found


def ids(found: list[dict[str, Any]]) -> list[list[str]]:
    return [[entry["engine_id"] for entry in page["engines"]] for page in found]


@pytest.mark.parametrize(("limit", "wanted"), [(1, [["a"], ["b"], ["c"], ["gateway"]]), (3, [IDS[:3], IDS[3:]])])
async def test_pages_show_every_engine_once(place: Place, limit: int, wanted: list[list[str]]) -> None:
    found = await pages(place, limit=limit)
    assert ids(found) == wanted
    assert {page["count"] for page in found} == {4}


async def test_an_entry_says_what_its_engine_owns(place: Place) -> None:
    ((a, b, c, gateway),) = (page["engines"] for page in await pages(place))
    assert (a["parent_id"], a["extensions"], gateway["parent_id"]) == ("gateway", [], "")
    assert b["extensions"] == ["rois.stream", "signaling"]
    lamp, bell = c["components"]
    assert (lamp["component_ref"], lamp["function"], bell["function"]) == ("c/lamp", "actuation", "sensing")
    assert lamp["component_type"] == "urn:x-rois:def:component:Test::Lamp"
    assert a["components"][0]["profile_version"] == lamp["profile_version"] != bell["profile_version"]
    assert gateway["components"] == []


async def test_engines_with_some_types(place: Place) -> None:
    lamp, bell = (f"urn:x-rois:def:component:Test::{name}" for name in ("Lamp", "Bell"))
    assert ids(await pages(place, component_types=[lamp])) == [["a", "c"]]
    assert ids(await pages(place, component_types=[lamp, bell], limit=1)) == [["c"]]
    assert ids(await pages(place, component_types=["urn:none"])) == [[]]


async def test_what_is_out_of_scope_is_not_there(place: Place) -> None:
    seen = principal("viewer", "c/bell", "a/*")
    found = await pages(place, seen)
    assert (ids(found), found[0]["count"]) == ([["a", "c", "gateway"]], 3)
    assert [each["component_ref"] for each in found[0]["engines"][1]["components"]] == ["c/bell"]
    async with place.application(seen) as app:
        read = await app.result("openrois.directory.read", {"engine_ids": ["b", "a", "a"]})
        assert [entry["engine_id"] for entry in read["engines"]] == ["a"]
        answer = await app.result("openrois.directory.profiles", {"component_refs": ["b/camera", "c/lamp"]})
        assert (answer["profiles"], answer["left"]) == ({}, [])


async def test_a_version_stands_for_what_an_engine_offers(place: Place) -> None:
    engine = place.host.engine
    async with place.application(EVERYTHING) as app:

        async def version() -> str:
            read = await app.result("openrois.directory.read", {"engine_ids": ["more"]})
            return str(read["engines"][0]["version"])

        versions = []
        for components in ([Lamp()], [Lamp()], [Bell()], [Lamp(), Bell()]):
            registry = LocalRegistry("more", components)
            await engine.attach(registry)
            versions.append(await version())
            engine.detach(registry)
        assert versions[0] == versions[1]
        assert len(set(versions)) == 3


async def test_profiles_by_their_versions(place: Place) -> None:
    async with place.application(EVERYTHING) as app:
        refs = ["a/lamp", "c/lamp", "c/bell", "a/lamp", "absent/lamp"]
        answer = await app.result("openrois.directory.profiles", {"component_refs": refs})
        assert sorted(each["name"] for each in answer["profiles"].values()) == ["bell", "lamp"]
        whole = await app.result("rois.system.get_profile", {})
        (entry,) = (await app.result("openrois.directory.read", {"engine_ids": ["c"]}))["engines"]
        for each in entry["components"]:
            assert answer["profiles"][each["profile_version"]] == whole["component_profiles"][each["component_ref"]]


async def test_replies_are_bounded(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(directory, "ITEMS", 2)
    monkeypatch.setattr(directory, "ROOM", 10)
    assert ids(await pages(place)) == [["a", "b"], ["c", "gateway"]]
    async with place.application(EVERYTHING) as app:
        read = await app.result("openrois.directory.read", {"engine_ids": ["a", "c", "none", "b"]})
        assert ([entry["engine_id"] for entry in read["engines"]], read["left"]) == (["a"], ["c", "none", "b"])
        answer = await app.result("openrois.directory.profiles", {"component_refs": ["a/lamp", "c/lamp", "c/bell"]})
        assert (len(answer["profiles"]), answer["left"]) == (1, ["c/bell"])


async def test_an_application_with_the_extension_is_told_of_engines(place: Place) -> None:
    async with place.application(EVERYTHING) as app:
        hello = await app.result("openrois.hello", {"version": "1", "extensions": ["openrois.directory"]})
        assert ("openrois.directory" in hello["extensions"], hello["engines"]) == (True, [])
        await place.host.engine.attach(LocalRegistry("more", [Lamp()]))
        told = await app.until("openrois.directory.changed")
        assert told == {"changed": ["more"], "gone": [], "unnamed": 0}
        await app.result("openrois.directory.list", {})
        assert [frame for frame in app.frames if "profile_changed" in frame] == []


@pytest.mark.parametrize(
    ("method", "params"),
    [
        ("list", {"limit": MAX_PAGE + 1}),
        ("list", {"limit": 0}),
        ("list", {"component_types": ["urn"] * 65}),
        ("read", {"engine_ids": ["a"] * (MAX_PAGE + 1)}),
        ("profiles", {"component_refs": ["a/lamp"] * (MAX_PROFILES + 1)}),
    ],
)
async def test_what_one_request_may_ask_of_the_directory(place: Place, method: str, params: dict[str, Any]) -> None:
    async with place.application(EVERYTHING) as app:
        assert await app.code(f"openrois.directory.{method}", params) == -32602
