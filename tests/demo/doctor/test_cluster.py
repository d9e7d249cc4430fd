"""What the doctor finds of real NATS and PostgreSQL, and of gateways there."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from openrois_demo.doctor import command
from openrois_demo.doctor.cluster import Shared, cluster, gateways, nats_server, own_id, ranks, store
from openrois_demo.doctor.cluster_options import add_cluster_options
from openrois_demo.doctor.finding import Finding, Level

from openrois.cli.command_line import CommandLine
from openrois.cluster.examination import HeardGateway, NatsServerFacts
from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.examination import KnownGateway, StoreFacts, examine_store
from openrois.cluster.postgres.schema import VERSION
from openrois.cluster.settings import NatsSettings
from openrois.gateway.configuration import settings_of
from tests.support.cluster import Cluster
from tests.support.nats import NatsServer, cluster_name
from tests.support.nats import nats_server as serving
from tests.support.place import place_of
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

GOOD = StoreFacts(
    name="PostgreSQL db/openrois",
    version="15.4",
    number=150004,
    user_name="openrois",
    is_standby=False,
    is_read_only=False,
    fsync=True,
    full_page_writes=True,
    synchronous_commit="on",
    free_connections=50,
    schema_version=VERSION,
    may_write=True,
    round_trip=0.001,
    ahead=0.0,
    gateways=(),
)


def store_of(postgres: Server) -> Database:
    return Database(postgres.url, postgres.password_file)


async def found(shared: Shared) -> dict[str, Finding]:
    return {finding.name: finding async for finding in cluster(shared)}


def shared(nats: str, postgres: Server, gateway_id: str = "", name: str = "", **more: Path) -> Shared:
    there = NatsSettings((nats,), prefix=name or cluster_name(), **more)
    return Shared(there, store_of(postgres), gateway_id)


def of(running: Cluster, gateway_id: str = "") -> Shared:
    return shared(running.nats.url, running.postgres, gateway_id, running.name)


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Listen for no gateway, where there is none."""
    monkeypatch.setattr("openrois.cluster.examination._LISTENING", 0.01)


def test_the_options_are_those_of_the_gateway() -> None:
    parser = CommandLine("p")
    add_cluster_options(parser)
    options = {each for action in parser._actions for each in action.option_strings}
    assert options - {"-h", "--help"} == {setting.option for setting in settings_of() if setting.table == "cluster"}


async def test_gateways_that_run_are_found_with_what_they_own(shared_nats: NatsServer, postgres_server: Server) -> None:
    async with place_of(shared_nats, postgres_server, "a", "b") as place:
        await place.attach("a")
        told = await found(of(place.cluster, "a"))
        assert {name for name, each in told.items() if each.level is not Level.OK} == {"durability", "gateway's id"}
        assert told["durability"].detail.startswith("fsync is off")
        assert told["gateway a"].detail.endswith("heard at NATS, owns robot")
        assert told["gateway b"].detail.endswith("heard at NATS, owns no engine")
        assert told["gateway's id"].detail == "a gateway a runs now"
        assert told["NATS"].detail.startswith(f"{shared_nats.url}, version 2.")
        assert told["schema"].detail == f"version {VERSION}"
        assert told["ranks"].detail == "person,agent,script"
        # It looks, and is no gateway itself.
        assert set(await found(of(place.cluster, "c"))) >= {"gateway a", "gateway b", "gateway's id"}
        federation = place.gateway("a").federation
        assert federation is not None
        assert federation.others == ("b",)


async def test_a_gateway_with_other_ranks_is_found(shared_nats: NatsServer, postgres_server: Server) -> None:
    async with place_of(shared_nats, postgres_server, "a", ranks="person, script") as place:
        await place.cluster.start("b", ranks="person,agent,script")
        told = await found(of(place.cluster))
        assert (told["ranks"].level, told["ranks"].detail) == (
            Level.WARN,
            "person,script at a; person,agent,script at b",
        )


@pytest.mark.usefixtures("brief")
async def test_an_empty_database_is_left_empty(shared_nats: NatsServer, postgres_server: Server) -> None:
    async with postgres_server.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
        told = await found(shared(shared_nats.url, postgres_server, "a"))
        assert await admin.fetchval("SELECT to_regnamespace('openrois') IS NULL")
    assert (told["schema"].level, told["schema"].detail) == (
        Level.OK,
        f"none yet: the first gateway makes version {VERSION}",
    )
    assert told["gateways"].detail == "none runs"
    assert told["gateway's id"].detail == "a is free"
    assert told["clocks"].level is Level.OK


@pytest.mark.long  # the server starts anew, twice
@pytest.mark.usefixtures("brief")
async def test_a_durable_server_is_one(shared_nats: NatsServer, postgres_server: Server) -> None:
    with postgres_server.configured(fsync="on", full_page_writes="on"):
        told = await found(shared(shared_nats.url, postgres_server))
    assert {each.level for each in told.values()} == {Level.OK}


async def test_what_is_not_there_is_said_with_what_to_do(tmp_path: Path) -> None:
    nowhere = Shared(NatsSettings(("nats://127.0.0.1:1",)), Database(f"postgresql://o@/d?host={tmp_path}"), "a")
    told = await found(nowhere)
    assert {name: each.level for name, each in told.items()} == {"NATS": Level.FAIL, "PostgreSQL": Level.FAIL}
    assert all(each.advice for each in told.values())


@pytest.mark.usefixtures("brief")
async def test_a_wrong_password_of_the_store_is_said(
    shared_nats: NatsServer, postgres_server: Server, tmp_path: Path
) -> None:
    (tmp_path / "password").write_text("another")
    wrong = Database(postgres_server.url, tmp_path / "password")
    told = await found(replace(shared(shared_nats.url, postgres_server), store=wrong))
    assert told["PostgreSQL"].level is Level.FAIL
    assert "password authentication failed" in told["PostgreSQL"].detail
    assert "another" not in told["PostgreSQL"].detail


async def test_a_user_that_may_not_write_is_said(postgres_server: Server) -> None:
    async with postgres_server.admin() as admin:
        await admin.execute("DROP ROLE IF EXISTS reader; CREATE ROLE reader LOGIN PASSWORD 'r'")
        await admin.execute("ALTER ROLE reader SET default_transaction_read_only = on")
        try:
            url = postgres_server.url.replace("openrois@", "reader@")
            password = postgres_server.password_file.with_name("reader")
            password.write_text("r")
            facts = await examine_store(Database(url, password))
        finally:
            await admin.execute("DROP ROLE reader")
    assert (facts.is_read_only, facts.may_write) == (True, False)


@pytest.mark.usefixtures("brief")
async def test_of_servers_of_nats_one_may_be_away(shared_nats: NatsServer, postgres_server: Server) -> None:
    nats = NatsSettings(("nats://127.0.0.1:1", shared_nats.url), prefix=cluster_name())
    told = [each async for each in cluster(Shared(nats, store_of(postgres_server), ""))]
    assert [each.level for each in told if each.name == "NATS"] == [Level.OK, Level.WARN]


@pytest.mark.usefixtures("brief")
async def test_nats_that_admits_nothing_takes_little_or_keeps_subjects_to_itself(
    tmp_path: Path, postgres_server: Server
) -> None:
    users = """
        authorization { users: [
            {user: a, password: b, permissions: {publish: "other.>", subscribe: ">"}}
        ] }
    """
    (tmp_path / "login").write_text("a\nb\n")
    with serving(tmp_path, users) as nats:
        told = await found(shared(nats.url, postgres_server))
        assert "does not admit this gateway" in told["NATS"].detail
        told = await found(shared(nats.url, postgres_server, credentials_file=tmp_path / "login"))
        assert (told["NATS"].level, "does not come back" in told["NATS"].detail) == (Level.FAIL, True)
    with serving(tmp_path, "max_payload: 8192") as nats:
        told = await found(shared(nats.url, postgres_server))
        assert told["NATS"].advice == "Set its max_payload to 49152 or more."


@pytest.mark.usefixtures("brief")
def test_the_command_ends_with_1_where_something_fails(
    capsys: pytest.CaptureFixture[str], shared_nats: NatsServer, postgres_server: Server
) -> None:
    words = ["--cluster", shared_nats.url, "--cluster-name", cluster_name(), "--store", postgres_server.url]
    words += ["--store-password", str(postgres_server.password_file)]
    assert command.main([*words, "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [each["name"] for each in told["findings"] if each["level"] == "fail"] == ["durability"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--cluster", "nats://127.0.0.1"],
        ["--cluster", "http://127.0.0.1", "--store", "postgresql://o@/d"],
        ["--cluster", "nats://127.0.0.1", "--cluster-credentials", "nowhere", "--store", "postgresql://o@/d"],
        ["--cluster", "nats://127.0.0.1", "--store", "postgresql://o:p@/d"],
        ["--cluster", "nats://127.0.0.1", "--store", "postgresql://o@/d", "--store-password", "nowhere"],
    ],
)
def test_wrong_options_end_with_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        command.main(arguments)
    assert raised.value.code == 2
    assert "openrois doctor: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "name", "level"),
    [
        ({}, "", Level.OK),
        ({"number": 140000}, "PostgreSQL", Level.WARN),
        ({"round_trip": 0.3}, "PostgreSQL", Level.WARN),
        ({"is_standby": True}, "writing", Level.FAIL),
        ({"is_read_only": True}, "writing", Level.FAIL),
        ({"may_write": False}, "writing", Level.FAIL),
        ({"may_write": False, "schema_version": None}, "writing", Level.FAIL),
        ({"schema_version": VERSION + 2}, "schema", Level.FAIL),
        ({"schema_version": VERSION + 1}, "", Level.OK),
        ({"schema_version": VERSION - 1}, "", Level.OK),
        ({"fsync": False}, "durability", Level.FAIL),
        ({"synchronous_commit": "off"}, "durability", Level.FAIL),
        ({"full_page_writes": False}, "durability", Level.WARN),
        ({"free_connections": 3}, "connections", Level.WARN),
        ({"ahead": 5.0}, "clocks", Level.WARN),
        ({"ahead": -5.0}, "clocks", Level.WARN),
    ],
)
def test_a_store_is_judged(change: dict[str, object], name: str, level: Level) -> None:
    told = store(replace(GOOD, **change))  # type: ignore[arg-type]
    assert [each.name for each in told if each.level is not Level.OK] == ([name] if name else [])
    assert level in {each.level for each in told}
    assert all(each.advice for each in told if each.level is not Level.OK)


def test_nats_far_away_is_said() -> None:
    assert nats_server("nats://n", NatsServerFacts("2.15.1", 1 << 20, 0.2)).level is Level.WARN
    assert nats_server("nats://n", NatsServerFacts("2.15.1", 1 << 20, 0.001)).level is Level.OK


def test_ranks_of_gateways_that_tell_none_are_not_judged() -> None:
    known, ours = HeardGateway("a", "1", "1", "person,script"), HeardGateway("b", "2", "1")
    strange = [HeardGateway("c", "3", "1", text) for text in ("", "a\nb", "x," * 100)]
    assert ranks([]) == ranks([ours, *strange]) == []
    assert [(each.level, each.detail) for each in ranks([known, ours])] == [(Level.OK, "person,script")]
    many = [HeardGateway(str(number), "1", "1", "person") for number in range(7)]
    (told,) = ranks([*many, known])
    assert told.detail == "person at 0, 1, 2, 3, 4 and 2 more; person,script at a"


def test_gateways_that_are_half_there_are_said() -> None:
    heard = [HeardGateway("a", "1", "1"), HeardGateway("a", "2", "1"), HeardGateway("b", "3", "1")]
    known = [KnownGateway("c", True, tuple("123456")), KnownGateway("d", False, ())]
    told = {each.name: each for each in gateways(known, heard)}
    assert {name: each.level for name, each in told.items()} == {
        "gateway a": Level.FAIL,
        "gateway b": Level.WARN,
        "gateway c": Level.WARN,
    }
    assert told["gateway c"].detail.endswith("owns 1, 2, 3, 4, 5 and 1 more")
    assert own_id("d", known, heard).detail == "a gateway d was there before, and has ended"
    assert own_id("c", known, heard).level is Level.WARN
