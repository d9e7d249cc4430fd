"""Publishers and subscriptions over DDS."""

from collections.abc import Callable, Mapping
from typing import Any

from openrois_robots.ros2.cyclone.participant import Participant, dds_qos
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.matching import Direction, Qos, topic_problem
from openrois_robots.ros2.graph.names import dds_topic

__all__ = ["DdsPublisher", "DdsSubscription"]


class _OfTopic:
    """An end of ours of a topic."""

    def __init__(self, participant: Participant, direction: Direction, name: str, type_name: str, qos: Qos) -> None:
        self.name = name
        self._participant = participant
        self._direction = direction
        self._type_name = type_name
        self._qos = qos

    def _problem(self, matches: int) -> str:
        if matches:
            return ""
        others = "publish" if self._direction == "subscribe" else "subscribe"
        peers = self._participant.peers(others, dds_topic(self.name))
        return topic_problem(self._direction, self.name, self._type_name, self._qos, peers)


class DdsPublisher(_OfTopic):
    """A publisher of a topic."""

    def __init__(self, participant: Participant, types: TypeMaker, name: str, type_name: str, qos: Qos) -> None:
        super().__init__(participant, "publish", name, type_name, qos)
        self._types = types
        kind = types.message(type_name)
        self._writer = participant.writer(dds_topic(name), kind, dds_qos(qos), lambda _is_lost: None)

    @property
    def is_matched(self) -> bool:
        """Whether a node subscribes to the topic."""
        return self._writer.matches > 0

    @property
    def problem(self) -> str:
        """Why none does."""
        return self._problem(self._writer.matches)

    def publish(self, message: Mapping[str, Any]) -> None:
        """Publish a message."""
        self._writer.write(self._types.value(self._type_name, message))

    def close(self) -> None:
        """Remove it from the graph."""
        self._participant.close_ends(self._writer)


class DdsSubscription(_OfTopic):
    """A subscription to a topic."""

    def __init__(
        self,
        participant: Participant,
        types: TypeMaker,
        name: str,
        type_name: str,
        qos: Qos,
        on_message: Callable[[Any], None],
    ) -> None:
        super().__init__(participant, "subscribe", name, type_name, qos)
        kind = types.message(type_name)
        self._reader = participant.reader(dds_topic(name), kind, dds_qos(qos), on_message, lambda _is_lost: None)

    @property
    def is_matched(self) -> bool:
        """Whether a node publishes the topic."""
        return self._reader.matches > 0

    @property
    def problem(self) -> str:
        """Why none does, or why what comes cannot be read."""
        if self._reader.flaw:
            return f"what comes on {self.name} cannot be read as {self._type_name}: {self._reader.flaw}"
        return self._problem(self._reader.matches)

    def close(self) -> None:
        """Remove it from the graph."""
        self._participant.close_ends(self._reader)
