"""The battery: what standing and driving take from it, what the charging mat gives, and its limits. Pure."""

from dataclasses import dataclass
from typing import Final

__all__ = ["Battery", "BatterySettings"]

_MINUTE: Final = 60.0
_REVIVED: Final = 0.05
"""Charge from which on a robot whose battery was empty moves again."""


@dataclass(frozen=True, slots=True)
class BatterySettings:
    """What the battery holds, and its limits.

    Attributes:
        charge: at the beginning, from 0 to 1.
        low: below it the robot takes no goal but the charging mat.
        standing: minutes for which a full battery lasts while the robot stands.
        driving: minutes for which it lasts at the highest speed.
        charging: minutes in which the mat fills an empty one.

    Raises:
        ValueError: a value is out of bounds; the text names it.
    """

    charge: float = 1.0
    low: float = 0.2
    standing: float = 240.0
    driving: float = 60.0
    charging: float = 20.0

    def __post_init__(self) -> None:
        for name, most in (("charge", 1.0), ("low", 0.9)):
            if not 0 <= getattr(self, name) <= most:
                raise ValueError(f"battery.{name} must be between 0 and {most:g}, not {getattr(self, name):g}")
        for name in ("standing", "driving", "charging"):
            if not 0.1 <= getattr(self, name) <= 100_000:
                raise ValueError(f"battery.{name} must be between 0.1 and 100000 minutes, not {getattr(self, name):g}")
        if self.driving > self.standing:
            raise ValueError("battery.driving must not be longer than battery.standing: driving takes more")


class Battery:
    """A battery.

    Args:
        settings: what it holds.

    Attributes:
        charge: from 0 to 1.
        is_charging: whether it gets fuller now.
        is_empty: whether it was used up, and is not charged by a twentieth yet: the robot stands.
    """

    def __init__(self, settings: BatterySettings) -> None:
        self._settings = settings
        self.charge = settings.charge
        self.is_charging = False
        self.is_empty = self.charge <= 0

    @property
    def is_low(self) -> bool:
        """Whether only the way to the charging mat is left."""
        return self.charge < self._settings.low or self.is_empty

    @property
    def refusal(self) -> str:
        """Why other goals than the charging mat are refused; empty while they are not."""
        if self.is_empty:
            return "the battery is empty; push the robot to its dock, and wait until it is charged"
        if self.is_low:
            return f"the battery is at {self.percent} %; below {100 * self._settings.low:.0f} % only the dock is a goal"
        return ""

    @property
    def percent(self) -> int:
        """The charge in per cent; 0 only where it is empty."""
        return max(round(100 * self.charge), 0 if self.charge <= 0 else 1)

    def advance(self, seconds: float, effort: float, on_mat: bool) -> None:
        """Let time pass.

        Args:
            seconds: that pass.
            effort: the speed, as a share of the highest.
            on_mat: whether the robot is on the charging mat.
        """
        settings = self._settings
        idle, full = 1 / (settings.standing * _MINUTE), 1 / (settings.driving * _MINUTE)
        rate = 1 / (settings.charging * _MINUTE) if on_mat else -(idle + (full - idle) * min(effort, 1.0))
        before = self.charge
        self.charge = min(1.0, max(0.0, before + rate * seconds))
        self.is_charging = on_mat and before < 1.0
        self.is_empty = self.charge <= 0 or (self.is_empty and self.charge < _REVIVED)
