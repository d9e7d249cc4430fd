"""The participant of one process in a DDS domain: readers, writers, and the ends that other nodes have.

Listeners of DDS run in threads of its own: what they have to tell is brought into the event loop, where samples are
taken. So the history of a reader is the queue of its topic, as long as its depth.
"""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final, Self, cast

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import DDSException, Entity, InstanceState, Listener, Policy
from cyclonedds.domain import DomainParticipant
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from openrois.errors import ComponentFailed
from openrois_robots.ros2.cyclone.domain import join_domain, leave_domain
from openrois_robots.ros2.cyclone.types import WireType
from openrois_robots.ros2.graph.matching import Peer, Qos
from openrois_robots.ros2.graph.names import ros_type

__all__ = ["Participant", "Reader", "Writer"]

_log = logging.getLogger(__name__)

_BATCH: Final = 100
"""Most samples that are taken at a time."""
_PATIENCE: Final = 100_000_000
"""Nanoseconds for which a reliable writer may wait until its history has room."""


class _End:
    """A reader or a writer, and the number of ends of others that it matches.

    Args:
        on_change: called in the event loop when that has changed, with whether one was lost.
    """

    def __init__(self, on_change: Callable[[bool], None]) -> None:
        self.matches = 0
        self._on_change = on_change
        self._entity: Entity | None = None

    def close(self) -> None:
        """Delete it; it may be called more than once."""
        entity, self._entity = self._entity, None
        if entity is not None:
            _delete(entity)

    def _note_matched(self, current: int, change: int) -> None:
        self.matches = current
        if self._entity is not None:
            self._on_change(change < 0)


class Writer(_End):
    """A writer of a topic."""

    def write(self, sample: Any) -> None:
        """Write a sample of the codec's type.

        Raises:
            ComponentFailed: DDS refused it.
            ValueError: a value in it does not fit its field.
        """
        if not isinstance(self._entity, DataWriter):
            raise ComponentFailed("the node has left the graph of ROS")
        try:
            self._entity.write(sample)
        except DDSException as error:
            raise ComponentFailed(f"DDS refused a message: {error}") from None
        except ValueError:
            raise
        except Exception as error:  # What its encoder raises is of many kinds: struct.error, AssertionError, ...
            raise ValueError(f"a value does not fit its field: {error}") from None

    def has_reader_of(self, user_data: bytes) -> bool:
        """Return whether it matches a reader with this user data, as that of a client of a service."""
        entity = self._entity
        if not isinstance(entity, DataWriter):
            return False
        found = (entity.get_matched_subscription_data(each) for each in entity.get_matched_subscriptions())
        return any(each is not None and _user_data(each) == user_data for each in found)


class Reader(_End):
    """A reader of a topic.

    Attributes:
        flaw: why the last message could not be read; empty where it could.
    """

    flaw = ""

    def _take(self) -> Any:
        """Take the next sample that can be read, or that says that its writer is gone; None: there is none.

        One at a time: DDS gives up all that are taken at once where one of them cannot be read.
        """
        while isinstance(self._entity, DataReader):
            try:
                (sample,) = self._entity.take(1) or (None,)
            except DDSException as error:
                _log.warning("%s", error)
                return None
            except Exception as error:  # What its decoder raises is of many kinds: UnicodeDecodeError, ...
                if not self.flaw:
                    _log.warning("a message cannot be read: %s: %s", type(error).__name__, error)
                self.flaw = f"{type(error).__name__}: {error}"
                continue
            if sample is not None and not isinstance(sample, InvalidSample):
                self.flaw = ""
            return sample
        return None

    def user_data_of(self, sample: Any) -> bytes | None:
        """Return the user data of the writer of a sample; None: it is gone."""
        if not isinstance(self._entity, DataReader):
            return None
        writer = self._entity.get_matched_publication_data(sample.sample_info.publication_handle)
        return None if writer is None else _user_data(writer)


class Participant:
    """A participant; `async with` it.

    Args:
        domain: its number, 0 to 232.
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._entity: DomainParticipant | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._topics: dict[str, tuple[Topic[Any], WireType]] = {}
        self._ends: list[_End] = []
        self._peers: dict[str, dict[Any, tuple[str, Peer]]] = {"publish": {}, "subscribe": {}}
        """By what they do: topic, type and quality of the ends of other participants, by their keys."""
        self._watching: list[Entity] = []

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        try:
            self._entity = await asyncio.to_thread(_join, self._domain)
        except DDSException as error:
            raise OSError(f"DDS cannot join domain {self._domain}: {error}; see CYCLONEDDS_URI") from None
        except UnicodeEncodeError as error:
            odd = error.object[error.start]
            raise OSError(f"CYCLONEDDS_URI has the character {odd!r}: name a file whose path is ASCII alone") from None
        self._watch("publish", BuiltinTopicDcpsPublication)
        self._watch("subscribe", BuiltinTopicDcpsSubscription)
        return self

    async def __aexit__(self, *_error: object) -> None:
        for end in self._ends:
            end.close()
        entities = [*self._watching, *(topic for topic, _ in self._topics.values()), self._entity]
        self._ends, self._watching, self._topics, self._entity = [], [], {}, None
        # It waits for threads of DDS, which may be about to call into this one.
        await asyncio.to_thread(_leave, self._domain, *(each for each in entities if each is not None))

    def writer(self, topic: str, kind: WireType, qos: DdsQos, on_change: Callable[[bool], None]) -> Writer:
        """Make a writer; `on_change` is called with whether a reader was lost."""
        writer = Writer(on_change)

        def on_matched(_writer: object, status: Any) -> None:
            self._call(writer._note_matched, status.current_count, status.current_count_change)

        listener = _listener(on_publication_matched=on_matched)
        writer._entity = DataWriter(self._node, self._topic(topic, kind), qos=qos, listener=listener)
        self._ends.append(writer)
        return writer

    def reader(
        self,
        topic: str,
        kind: WireType,
        qos: DdsQos,
        on_sample: Callable[[Any], None],
        on_change: Callable[[bool], None],
    ) -> Reader:
        """Make a reader; `on_change` is called with whether a writer was lost, `on_sample` with what they write."""
        reader = Reader(on_change)
        announced = False

        def on_matched(_reader: object, status: Any) -> None:
            self._call(reader._note_matched, status.current_count, status.current_count_change)

        def on_data(_reader: object) -> None:
            nonlocal announced
            if not announced:
                announced = True
                self._call(drain)

        def drain() -> None:
            nonlocal announced
            announced = False
            for _ in range(_BATCH):
                if (sample := reader._take()) is None:
                    return
                if not isinstance(sample, InvalidSample):
                    on_sample(sample)
            # The others have their turn before what is left.
            on_data(reader)

        listener = _listener(on_subscription_matched=on_matched, on_data_available=on_data)
        reader._entity = DataReader(self._node, self._topic(topic, kind), qos=qos, listener=listener)
        self._ends.append(reader)
        # What came before there was an entity to take it from.
        self._call(drain)
        return reader

    def close_ends(self, *ends: _End) -> None:
        """Close ends before the participant leaves."""
        for end in ends:
            end.close()
            if end in self._ends:
                self._ends.remove(end)

    def peers(self, does: str, topic: str) -> list[Peer]:
        """Return the ends of other participants that `publish` or `subscribe` to a topic of DDS."""
        return [peer for name, peer in self._peers[does].values() if name == topic]

    @property
    def _node(self) -> DomainParticipant:
        if self._entity is None:
            raise ComponentFailed("the node has left the graph of ROS")
        return self._entity

    def _topic(self, name: str, kind: WireType) -> Topic[Any]:
        known = self._topics.get(name)
        if known is None:
            # Without quality of service: ends of one topic may have several, and DDS compares a topic's own.
            topic: Topic[Any] = Topic(self._node, name, kind.declared)
            topic.data_type = kind.codec
            known = self._topics[name] = topic, kind
        if known[1].declared is not kind.declared:
            other, asked = (ros_type(each.declared.__idl_typename__) for each in (known[1], kind))
            raise ComponentFailed(f"{name} is used with two types, {other} and {asked}: a topic has one")
        return known[0]

    def _watch(self, does: str, builtin: Any) -> None:
        known, own = self._peers[does], self._node.guid

        def read() -> None:
            if self._entity is None:
                return
            for sample in reader.take(_BATCH):
                _note_peer(known, sample, own)

        reader = BuiltinDataReader(
            self._node, builtin, listener=_listener(on_data_available=lambda _: self._call(read))
        )
        self._watching.append(reader)
        read()

    def _call(self, function: Callable[..., None], *arguments: object) -> None:
        assert self._loop is not None
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function, *arguments)


def dds_qos(qos: Qos, user_data: bytes = b"") -> DdsQos:
    """Return the quality of service for DDS, with the representation of data that ROS has (XCDR1)."""
    policies: list[Any] = [
        Policy.Reliability.Reliable(_PATIENCE) if qos.reliability == "reliable" else Policy.Reliability.BestEffort,
        Policy.History.KeepLast(qos.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.WriterDataLifecycle(autodispose=False),
    ]
    if qos.durability == "transient_local":
        policies.append(Policy.Durability.TransientLocal)
        policies.append(Policy.DurabilityService(0, Policy.History.KeepLast(qos.depth), -1, -1, -1))
    if user_data:
        policies.append(Policy.Userdata(user_data))
    return DdsQos(*policies)


def ros_qos(qos: DdsQos) -> Qos:
    """Return what ROS calls reliability and durability of a quality of service of DDS."""
    is_reliable = not isinstance(qos[Policy.Reliability], type(Policy.Reliability.BestEffort))
    is_kept = qos[Policy.Durability] != Policy.Durability.Volatile
    return Qos("reliable" if is_reliable else "best_effort", "transient_local" if is_kept else "volatile")


def _note_peer(known: dict[Any, tuple[str, Peer]], sample: Any, own: Any) -> None:
    """Note the end of another participant that has come or gone: a sample of `DcpsEndpoint`."""
    if sample.participant_key != own:
        if sample.sample_info.instance_state == InstanceState.Alive and sample.qos is not None:
            known[sample.key] = sample.topic_name, Peer(ros_type(sample.type_name), ros_qos(sample.qos))
        else:
            known.pop(sample.key, None)


def _listener(**callbacks: Callable[..., None]) -> Listener:
    return cast("Callable[..., Listener]", Listener)(**callbacks)


def _user_data(endpoint: Any) -> bytes:
    policy = endpoint.qos[Policy.Userdata]
    return b"" if policy is None else bytes(policy.data)


def _join(domain: int) -> DomainParticipant:
    """Return a new participant of a domain."""
    join_domain(domain)
    try:
        return DomainParticipant(domain)
    except DDSException:
        leave_domain(domain)
        raise


def _leave(domain: int, *entities: Entity) -> None:
    """Leave a domain with all entities of a participant."""
    _delete(*entities)
    leave_domain(domain)


def _delete(*entities: Entity) -> None:
    """Delete entities now: the binding deletes one with its object, and listeners refer to it and keep it."""
    for entity in entities:
        entity.__del__()
