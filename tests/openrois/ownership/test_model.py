"""Gateways, adapters and a store that loses messages, commits and its clock: no two owners with the same epochs."""

import asyncio
import logging
import os
from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test

from openrois.errors import StoreUnreachable
from openrois.ownership.claims import Claim
from openrois.ownership.directorate import Directorate
from openrois.ownership.errors import ClaimRefused
from openrois.ownership.memory_store import Gateway as StoredGateway
from openrois.ownership.memory_store import MemoryStore
from openrois.ownership.rules import BLOCK, Record
from tests.support.clock import Clock
from tests.support.lossy_store import Fate, LossyStore
from tests.support.ownership import blocks_overlap, never

pytestmark = pytest.mark.extra(name="base")

ENGINES = ("kachaka", "reachy")
GATEWAYS = ("a", "b", "c")


@dataclass
class Adapter:
    """One process that brings an engine; it has one connection, and remembers the greatest epoch that it saw."""

    engine_id: str
    instance: str
    seen: int = 0
    at: str = ""


@dataclass
class Gateway:
    """One process of a gateway, with the holders that it counts for each engine."""

    store: LossyStore
    clock: Clock
    directorate: Directorate
    counted: dict[str, int] = field(default_factory=dict)


class OwnershipMachine(RuleBasedStateMachine):
    """Three gateways, three places from which adapters of one engine dial, and one of another engine."""

    places = st.integers(0, 3)
    names = st.sampled_from(GATEWAYS)
    engines = st.sampled_from(ENGINES)
    holders = st.sampled_from((0, 1, BLOCK // 2, BLOCK))
    fates = st.sampled_from(
        (
            (),
            (),
            (Fate.LOST,),
            (Fate.ANSWER_LOST,),
            (Fate.LATE,),
            # What is read arrives; what is written does not, or late, or is not confirmed, and may be read again.
            (Fate.ARRIVES, Fate.LOST),
            (Fate.ARRIVES, Fate.ANSWER_LOST),
            (Fate.ARRIVES, Fate.ANSWER_LOST, Fate.LOST),
            (Fate.ARRIVES, Fate.LATE),
            (Fate.ARRIVES, Fate.LATE, Fate.LOST),
        )
    )

    def __init__(self) -> None:
        super().__init__()
        self.runner = asyncio.Runner()
        self.numbers = count(1)
        self.wall = Clock(1_900_000_000.0)
        self.store = MemoryStore(self.wall)
        self.adapters = [self.new_adapter(ENGINES[place // 3]) for place in range(4)]
        self.gateways = {name: self.new_gateway(name) for name in GATEWAYS}
        self.granted: dict[str, dict[int, Claim]] = defaultdict(dict)
        self.loses_commits = False
        self.last = 0

    def teardown(self) -> None:
        for gateway in self.gateways.values():
            self.run(gateway.directorate.__aexit__(None, None, None))
        self.runner.close()

    def run(self, work: Any) -> Any:
        return self.runner.run(work)

    def new_adapter(self, engine_id: str) -> Adapter:
        return Adapter(engine_id, f"process {next(self.numbers)}")

    def new_gateway(self, name: str) -> Gateway:
        store, clock = LossyStore(self.store), Clock(1000.0 * next(self.numbers))
        directorate = Directorate(store, name, patience=60.0, clock=clock, sleep=never)
        self.run(directorate.__aenter__())
        return Gateway(store, clock, directorate)

    @rule(place=places, name=names, fates=fates, holders=holders)
    def dial(self, place: int, name: str, fates: tuple[Fate, ...], holders: int) -> None:
        """An adapter connects to a gateway, which claims its engine and numbers some holders."""
        self.last = place
        self.connect(self.adapters[place], name, fates)
        self.lead(self.adapters[place], holders)

    @rule(name=names, fates=fates, holders=holders)
    def dial_on(self, name: str, fates: tuple[Fate, ...], holders: int) -> None:
        """The adapter that dialled last does so again, mostly elsewhere."""
        self.dial(self.last, name, fates, holders)

    @rule(name=names, step=st.sampled_from((1, 2)), holders=holders)
    def dial_as_rival(self, name: str, step: int, holders: int) -> None:
        """Another adapter of the engine that was dialled for last."""
        if self.last < len(self.adapters) - 1:
            self.dial((self.last + step) % (len(self.adapters) - 1), name, (), holders)

    def connect(self, adapter: Adapter, name: str, fates: tuple[Fate, ...]) -> None:
        gateway = self.gateways[name]
        adapter.at = ""
        record = self.store.records.get(adapter.engine_id)
        owner = self.gateways.get(record.gateway_id) if record is not None else None
        held = owner.directorate.claims.get(adapter.engine_id) if owner is not None else None
        is_kept = (
            (record is not None and owner is not None and held is not None)
            and owner.directorate.holds(adapter.engine_id)
            and held.first_epoch == record.first_epoch
            and held.instance != adapter.instance
        )
        gateway.store.fates = list(fates)
        try:
            claim = self.run(gateway.directorate.claim(adapter.engine_id, adapter.instance, above=adapter.seen))
        except (ClaimRefused, StoreUnreachable):
            return
        finally:
            gateway.store.fates = []
        assert claim.first_epoch + BLOCK - 1 == claim.last_epoch > adapter.seen
        former = self.granted[adapter.engine_id]
        known = former.get(claim.first_epoch)
        if known is None or (known.gateway_id, known.instance) != (name, adapter.instance):
            # Another adapter process comes in when the former owner has released, or sees itself that its time is over.
            # Where its last renewal is lost it may see that a moment too late: its epochs are apart nevertheless.
            assert self.loses_commits or not is_kept
            assert self.loses_commits or all(each.last_epoch < claim.first_epoch for each in former.values())
            gateway.counted[adapter.engine_id] = claim.first_epoch
        former[claim.first_epoch] = claim
        adapter.at = name

    def lead(self, adapter: Adapter, holders: int) -> None:
        """The gateway with the connection numbers new holders; the adapter sees the epoch of the last one."""
        gateway = self.gateways.get(adapter.at)
        claim = gateway.directorate.claims.get(adapter.engine_id) if gateway is not None else None
        if gateway is None or claim is None or claim.instance != adapter.instance or not holders:
            return
        epoch = min(max(gateway.counted.get(adapter.engine_id, 0), claim.first_epoch) + holders - 1, claim.last_epoch)
        gateway.counted[adapter.engine_id] = epoch
        assert epoch >= adapter.seen
        adapter.seen = epoch

    @rule(place=places)
    def restart_adapter(self, place: int) -> None:
        self.adapters[place] = self.new_adapter(self.adapters[place].engine_id)

    @rule(name=names, engine_id=engines, fates=fates)
    def release(self, name: str, engine_id: str, fates: tuple[Fate, ...]) -> None:
        gateway = self.gateways[name]
        gateway.store.fates = list(fates)
        with suppress(StoreUnreachable):
            self.run(gateway.directorate.release(engine_id))
        gateway.store.fates = []
        for adapter in self.adapters:
            if adapter.engine_id == engine_id and adapter.at == name:
                adapter.at = ""

    @rule(name=names, fates=fates)
    def renew(self, name: str, fates: tuple[Fate, ...]) -> None:
        gateway = self.gateways[name]
        gateway.store.fates = list(fates)
        with suppress(StoreUnreachable):
            self.run(gateway.directorate.renew())
        gateway.store.fates = []

    @rule()
    def arrive_late(self) -> None:
        for gateway in self.gateways.values():
            self.run(gateway.store.arrive())

    @rule(name=names, network=st.sampled_from(("good", "good", "deaf", "cut")))
    def change_network(self, name: str, network: str) -> None:
        store = self.gateways[name].store
        store.is_deaf, store.is_cut = network == "deaf", network == "cut"

    @rule(name=names)
    def kill_gateway(self, name: str) -> None:
        """A process ends without a word, and another one starts under its id."""
        killed = self.gateways[name]
        killed.store.is_cut = True
        self.run(killed.directorate.__aexit__(None, None, None))
        for adapter in self.adapters:
            adapter.at = "" if adapter.at == name else adapter.at
        self.gateways[name] = self.new_gateway(name)

    @rule(seconds=st.integers(1, 15), renewing=st.sets(names))
    def wait(self, seconds: int, renewing: set[str]) -> None:
        for _ in range(seconds):
            self.wall.now += 1
            for name, gateway in self.gateways.items():
                gateway.clock.now += 1
                if name in renewing:
                    self.renew(name, ())

    @rule(seconds=st.sampled_from((-3600, -12, 12, 3600)))
    def step_clock(self, seconds: int) -> None:
        self.wall.now += seconds

    @invariant()
    def blocks_are_apart(self) -> None:
        for claims in self.granted.values():
            if not self.loses_commits:
                assert not blocks_overlap((each.first_epoch, each.last_epoch) for each in claims.values())

    def all_renew(self) -> None:
        for gateway in self.gateways.values():
            gateway.store.is_cut = gateway.store.is_deaf = False
            self.run(gateway.store.arrive())
        for _ in range(2):
            for name in GATEWAYS:
                self.renew(name, ())

    @rule()
    def all_agree_when_all_have_renewed(self) -> None:
        self.all_renew()
        stored = {each.engine_id: each for each in self.run(self.store.owners(None))}
        for name, gateway in self.gateways.items():
            assert gateway.directorate.owners == stored
            owned = {engine_id: owner.epoch for engine_id, owner in stored.items() if owner.gateway_id == name}
            assert {each.engine_id: each.first_epoch for each in gateway.directorate.claims.values()} == owned


class LosingMachine(OwnershipMachine):
    """The store loses its last commits as well: no block that is granted then has epochs that its adapter has seen."""

    def __init__(self) -> None:
        super().__init__()
        self.loses_commits = True
        self.copy: tuple[dict[str, Record], dict[str, StoredGateway]] = {}, {}

    @rule()
    def keep_copy(self) -> None:
        self.copy = dict(self.store.records), dict(self.store.gateways)

    @precondition(lambda self: self.copy[1])
    @rule()
    def lose_commits(self) -> None:
        self.store.records, self.store.gateways = dict(self.copy[0]), dict(self.copy[1])


@pytest.mark.timeout(900)
@pytest.mark.parametrize("machine", [OwnershipMachine, LosingMachine])
def test_no_two_owners_have_the_same_epochs(machine: type[OwnershipMachine], caplog: pytest.LogCaptureFixture) -> None:
    """`OPENROIS_CLAIM_RUNS=5000` tries many more; that takes some minutes."""
    caplog.set_level(logging.CRITICAL)
    runs = int(os.environ.get("OPENROIS_CLAIM_RUNS", "100"))
    chosen = settings(
        max_examples=runs, stateful_step_count=40, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    run_state_machine_as_test(machine, settings=chosen)
