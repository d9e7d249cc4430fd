"""Findings about what gateways share: NATS, PostgreSQL, and these gateways. Needs `openrois[cluster]`."""

from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from typing import Final

from openrois.auth.ranks import Ranks
from openrois.cluster.examination import HeardGateway, NatsServerFacts, examine_server, hear_gateways
from openrois.cluster.handshake import Unreachable
from openrois.cluster.link import LEAST_PAYLOAD
from openrois.cluster.postgres.database import CONNECTIONS, Database
from openrois.cluster.postgres.examination import NEWEST, VERSION, KnownGateway, StoreFacts, examine_store
from openrois.cluster.settings import NatsSettings
from openrois.errors import StoreUnreachable
from openrois_demo.doctor.finding import Finding, Level

__all__ = ["Shared", "cluster", "gateways", "nats_server", "own_id", "ranks", "store"]

_SLOW_NATS: Final = 0.05
_SLOW_STORE: Final = 0.1
_CLOCK: Final = 1.0
_OLDEST_POSTGRES: Final = 150000
_LISTED: Final = 5


@dataclass(frozen=True, slots=True)
class Shared:
    """What a gateway would be started with.

    Attributes:
        nats: where NATS is.
        store: where the database is; it is not entered.
        gateway_id: the gateway's id; empty where none was given.
    """

    nats: NatsSettings
    store: Database
    gateway_id: str


async def cluster(shared: Shared) -> AsyncIterator[Finding]:
    """Yield what is found of NATS, of PostgreSQL and of the gateways there."""
    reached = ""
    servers = shared.nats.servers
    refused = []
    for server in servers:
        try:
            facts = await examine_server(shared.nats, server, LEAST_PAYLOAD)
        except Unreachable as error:
            refused.append(str(error))
            continue
        reached = reached or server
        yield nats_server(server, facts)
    for problem in refused:
        advice = "Start it, or correct --cluster and what it is shown (--cluster-credentials, --cluster-ca)."
        yield Finding(Level.WARN if reached else Level.FAIL, "NATS", problem, advice)
    heard = await hear_gateways(shared.nats, reached) if reached else None
    known: Sequence[KnownGateway] = ()
    try:
        found = await examine_store(shared.store)
    except StoreUnreachable as error:
        advice = "Start it, let this machine in (pg_hba.conf), or correct --store and --store-password."
        yield Finding(Level.FAIL, "PostgreSQL", str(error), advice)
    else:
        known = found.gateways
        for finding in store(found):
            yield finding
    if heard is not None:
        for finding in (*gateways(known, heard), *ranks(heard)):
            yield finding
        if shared.gateway_id:
            yield own_id(shared.gateway_id, known, heard)


def nats_server(server: str, facts: NatsServerFacts) -> Finding:
    """Say whether a server that was reached serves gateways."""
    told = f"{server}, version {facts.version}, takes {facts.max_payload} bytes at a time"
    if facts.max_payload < LEAST_PAYLOAD:
        return Finding(Level.FAIL, "NATS", told, f"Set its max_payload to {LEAST_PAYLOAD} or more.")
    if facts.round_trip is None:
        advice = "Let this user publish and subscribe to all subjects below the name of the cluster (--cluster-name)."
        return Finding(Level.FAIL, "NATS", f"{told}; a message does not come back", advice)
    told = f"{told}, {1000 * facts.round_trip:.1f} ms there and back"
    if facts.round_trip > _SLOW_NATS:
        advice = "Every request to a body of another gateway takes twice that: run NATS beside the gateways."
        return Finding(Level.WARN, "NATS", told, advice)
    return Finding(Level.OK, "NATS", told)


def store(facts: StoreFacts) -> list[Finding]:
    """Say whether a database that was reached can be the store."""
    return [_server(facts), _writing(facts), _schema(facts), _durability(facts), _connections(facts), _clock(facts)]


def _server(facts: StoreFacts) -> Finding:
    told = f"{facts.name}, version {facts.version}, {1000 * facts.round_trip:.1f} ms there and back"
    if facts.number < _OLDEST_POSTGRES:
        return Finding(Level.WARN, "PostgreSQL", told, "Version 15 was tried; an older one may lack what is needed.")
    if facts.round_trip > _SLOW_STORE:
        advice = "A claim takes some of these, and fails after 1 s: run PostgreSQL nearer, or look what else it does."
        return Finding(Level.WARN, "PostgreSQL", told, advice)
    return Finding(Level.OK, "PostgreSQL", told)


def _writing(facts: StoreFacts) -> Finding:
    name = "writing"
    if facts.is_standby:
        advice = "Name the primary; with all servers in --store (HOST,HOST) the one that takes changes is used."
        return Finding(Level.FAIL, name, "it is a standby, and takes no changes", advice)
    if facts.is_read_only:
        advice = "ALTER ROLE or ALTER DATABASE ... RESET default_transaction_read_only."
        return Finding(Level.FAIL, name, "it takes no changes: transactions are read-only", advice)
    if not facts.may_write:
        advice = f"Let {facts.user_name} own the database: ALTER DATABASE ... OWNER TO {facts.user_name}."
        what = "make the schema" if facts.schema_version is None else "change the tables of the schema"
        return Finding(Level.FAIL, name, f"{facts.user_name} may not {what} openrois", advice)
    return Finding(Level.OK, name, f"{facts.user_name} may write")


def _schema(facts: StoreFacts) -> Finding:
    found, name = facts.schema_version, "schema"
    if found is None:
        return Finding(Level.OK, name, f"none yet: the first gateway makes version {VERSION}")
    if found > NEWEST:
        advice = "Install what the other gateways run, or run `openrois gateway --migrate-store-back` of that."
        return Finding(Level.FAIL, name, f"version {found}, and this program works with up to {NEWEST}", advice)
    if found > VERSION:
        return Finding(Level.OK, name, f"version {found}, made by a newer OpenRoIS: this one works with it")
    if found < VERSION:
        return Finding(Level.OK, name, f"version {found}: the next gateway that starts makes it version {VERSION}")
    return Finding(Level.OK, name, f"version {found}")


def _durability(facts: StoreFacts) -> Finding:
    name = "durability"
    if not facts.fsync:
        advice = "Set fsync = on: after a loss of power an engine could have two owners with one epoch."
        return Finding(Level.FAIL, name, "fsync is off: what was confirmed may be lost", advice)
    if facts.synchronous_commit in ("off", "local"):
        advice = "Gateways ask for `on`, and something between changes that: connect without that pooler."
        return Finding(Level.FAIL, name, f"synchronous_commit is {facts.synchronous_commit}", advice)
    if not facts.full_page_writes:
        advice = "Set full_page_writes = on, unless the file system never writes half a page."
        return Finding(Level.WARN, name, "full_page_writes is off: a loss of power may spoil pages", advice)
    return Finding(Level.OK, name, f"fsync, and synchronous_commit {facts.synchronous_commit}")


def _connections(facts: StoreFacts) -> Finding:
    needed = CONNECTIONS + 1
    told = f"{facts.free_connections} are free, and a gateway makes {needed} at most"
    if facts.free_connections < needed:
        return Finding(Level.WARN, "connections", told, f"Raise max_connections: {needed} for each gateway.")
    return Finding(Level.OK, "connections", told)


def _clock(facts: StoreFacts) -> Finding:
    side = "ahead of" if facts.ahead > 0 else "behind"
    told = f"PostgreSQL's is {abs(facts.ahead):.3f} s {side} this machine's"
    if abs(facts.ahead) > max(_CLOCK, facts.round_trip):
        advice = "Set both by a time server: claims hold nevertheless, but tokens end by this machine's clock."
        return Finding(Level.WARN, "clocks", told, advice)
    return Finding(Level.OK, "clocks", told)


def gateways(known: Sequence[KnownGateway], heard: Sequence[HeardGateway]) -> list[Finding]:
    """Say which gateways there are by NATS and by PostgreSQL, what they own, and where these differ."""
    processes = {each.gateway_id: [one for one in heard if one.gateway_id == each.gateway_id] for each in heard}
    stored = {each.gateway_id: each for each in known}
    running = sorted(processes.keys() | {each.gateway_id for each in known if each.holds})
    if not running:
        return [Finding(Level.OK, "gateways", "none runs")]
    return [_gateway(each, stored.get(each), processes.get(each, [])) for each in running]


def _gateway(gateway_id: str, stored: KnownGateway | None, processes: Sequence[HeardGateway]) -> Finding:
    name = f"gateway {gateway_id}"
    owned = f"owns {_listed(stored.engine_ids)}" if stored is not None else "is not in this store"
    if len(processes) > 1:
        told = f"{len(processes)} processes at NATS have this id"
        return Finding(Level.FAIL, name, told, "Stop one, or give it a --gateway-id of its own.")
    if not processes:
        advice = "It ended within its last 10 s, or does not reach this NATS, or has another --cluster-name."
        return Finding(Level.WARN, name, f"is in the store and not heard at NATS; {owned}", advice)
    told = f"version {processes[0].version}, heard at NATS, {owned}"
    if stored is None or not stored.holds:
        advice = "It does not renew its claims here: it does not reach this PostgreSQL, or has another --store."
        return Finding(Level.WARN, name, told, advice)
    return Finding(Level.OK, name, told)


def ranks(heard: Sequence[HeardGateway]) -> list[Finding]:
    """Say whether all gateways know the same ranks; of one that says none, or what are none, nothing is said."""
    gateway_ids: dict[str, dict[str, None]] = {}
    for each in heard:
        try:
            known = ",".join(Ranks.parse(each.ranks).names)
        except ValueError:
            continue
        gateway_ids.setdefault(known, {})[each.gateway_id] = None
    if len(gateway_ids) > 1:
        told = "; ".join(f"{known} at {_listed(tuple(ids))}" for known, ids in gateway_ids.items())
        advice = "Give all the same --ranks: a rank that the owner of a body does not know counts as the lowest."
        return [Finding(Level.WARN, "ranks", told, advice)]
    return [Finding(Level.OK, "ranks", known) for known in gateway_ids]


def own_id(gateway_id: str, known: Sequence[KnownGateway], heard: Sequence[HeardGateway]) -> Finding:
    """Say whether a gateway has the id already with which one is to be started."""
    runs = any(each.gateway_id == gateway_id for each in heard)
    runs = runs or any(each.gateway_id == gateway_id and each.holds for each in known)
    if runs:
        advice = "Unless that is this one, choose another --gateway-id: of two the later one takes everything over."
        return Finding(Level.WARN, "gateway's id", f"a gateway {gateway_id} runs now", advice)
    if any(each.gateway_id == gateway_id for each in known):
        return Finding(Level.OK, "gateway's id", f"a gateway {gateway_id} was there before, and has ended")
    return Finding(Level.OK, "gateway's id", f"{gateway_id} is free")


def _listed(engine_ids: Sequence[str]) -> str:
    if not engine_ids:
        return "no engine"
    more = len(engine_ids) - _LISTED
    return ", ".join(engine_ids[:_LISTED]) + (f" and {more} more" if more > 0 else "")
