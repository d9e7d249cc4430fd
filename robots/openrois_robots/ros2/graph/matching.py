"""Whether two ends of a topic match, and what to change where they do not. Pure.

A subscriber asks and a publisher offers: reliable and transient_local can be asked for only where they are offered
(https://docs.ros.org/en/jazzy/Concepts/Intermediate/About-Quality-of-Service-Settings.html).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = ["BEST_EFFORT", "Direction", "Durability", "Peer", "Qos", "Reliability", "is_match", "topic_problem"]

Reliability: TypeAlias = Literal["reliable", "best_effort"]
Durability: TypeAlias = Literal["volatile", "transient_local"]
Direction: TypeAlias = Literal["publish", "subscribe"]


@dataclass(frozen=True, slots=True)
class Qos:
    """Quality of service of one end of a topic.

    Attributes:
        reliability: whether what is lost is sent again.
        durability: whether a subscriber that comes later gets the last messages.
        depth: messages that are kept; of a subscriber's, the newest wins.
    """

    reliability: Reliability = "reliable"
    durability: Durability = "volatile"
    depth: int = 10


BEST_EFFORT = Qos("best_effort", "volatile", 1)
"""The newest message of a sensor: it matches every publisher."""


@dataclass(frozen=True, slots=True)
class Peer:
    """The end of a topic that another node has: its type, as `nav_msgs/msg/Odometry`, and what it asks or offers."""

    type: str
    qos: Qos


def is_match(direction: Direction, type_name: str, qos: Qos, peer: Peer) -> bool:
    """Return whether an end of ours matches one of another node."""
    asks, offers = (qos, peer.qos) if direction == "subscribe" else (peer.qos, qos)
    return type_name == peer.type and not _lacking(asks, offers)


def topic_problem(direction: Direction, topic: str, type_name: str, qos: Qos, peers: Sequence[Peer]) -> str:
    """Return why an end of ours has no match, and what to change: a sentence without a full stop.

    Args:
        direction: whether ours publishes or subscribes.
        topic: its name.
        type_name: of our messages.
        qos: of our end.
        peers: the ends of other nodes with the opposite direction, none of which matches.
    """
    if not peers:
        return f"no node {'publishes' if direction == 'subscribe' else 'subscribes to'} {topic}"
    does = "is published" if direction == "subscribe" else "is subscribed to"
    same = [each for each in peers if each.type == type_name]
    if not same:
        return f"{topic} {does} as {peers[0].type}, and the mapping file has {type_name}: correct the type or the topic"
    asks, offers = (qos, same[0].qos) if direction == "subscribe" else (same[0].qos, qos)
    lacking = _lacking(asks, offers)
    if not lacking:
        return (
            f"{topic} {does} as {type_name}, and does not match: the robot has another definition of it;"
            " name its distribution, or the folder with its interfaces, in [ros]"
        )
    theirs, ours = getattr(same[0].qos, lacking), getattr(qos, lacking)
    return f'{topic} {does} {theirs}, and the mapping file has {ours}: set {lacking} = "{theirs}" for it'


def _lacking(asks: Qos, offers: Qos) -> str:
    """Return the policy in which less is offered than asked for; empty: none."""
    if asks.reliability == "reliable" and offers.reliability == "best_effort":
        return "reliability"
    if asks.durability == "transient_local" and offers.durability == "volatile":
        return "durability"
    return ""
