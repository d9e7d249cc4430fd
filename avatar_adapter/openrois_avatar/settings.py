"""What can be set on the avatar adapter."""

from dataclasses import dataclass
from typing import Final

__all__ = ["ENGINES", "AvatarSettings"]

ENGINES: Final = ("auto", "panda3d", "puppet", "synthetic")
"""What may render the avatar: `auto` is Panda3D where it runs and else the puppet; `synthetic` is a test picture."""


@dataclass(frozen=True, slots=True)
class AvatarSettings:
    """The settings of one avatar adapter.

    Attributes:
        gateway: `ws://host:port/adapter` of the gateway.
        engine_id: leads every ref of this avatar; unique behind its gateway.
        engine: one of `ENGINES`.
    """

    gateway: str = "ws://127.0.0.1:8765/adapter"
    engine_id: str = "avatar"
    engine: str = "auto"
