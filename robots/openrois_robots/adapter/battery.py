"""The battery of a robot as its adapter knows it, and the charge below which goals are refused. Pure."""

from dataclasses import dataclass
from typing import Protocol

__all__ = ["Battery", "BatteryLimit", "ReportedBattery"]


class Battery(Protocol):
    """The battery of a robot."""

    @property
    def percent(self) -> int | None:
        """The charge in per cent; None while the robot has not told it."""
        ...

    @property
    def is_charging(self) -> bool:
        """Whether it gets fuller now."""
        ...

    @property
    def is_low(self) -> bool:
        """Whether only the way to the charger is left."""
        ...

    @property
    def refusal(self) -> str:
        """Why other goals than the charger are refused; empty while they are not."""
        ...


@dataclass(frozen=True, slots=True)
class BatteryLimit:
    """The limit on the charge.

    Attributes:
        low: per cent below which only the way to the charger is left; 0: never.

    Raises:
        ValueError: it is out of bounds.
    """

    low: float = 15.0

    def __post_init__(self) -> None:
        if not 0 <= self.low <= 90:
            raise ValueError(f"battery.low must be between 0 and 90 per cent, not {self.low:g}")


@dataclass(slots=True)
class ReportedBattery:
    """A battery whose state the robot reports.

    Attributes:
        limit: below which goals are refused.
        percent: the charge in per cent; None while the robot has not told it.
        is_charging: whether it gets fuller now.
    """

    limit: BatteryLimit
    percent: int | None = None
    is_charging: bool = False

    @property
    def is_low(self) -> bool:
        """Whether only the way to the charger is left. A charge that is not known is not low."""
        return self.percent is not None and self.percent < self.limit.low

    @property
    def refusal(self) -> str:
        """Why other goals than the charger are refused; empty while they are not."""
        if not self.is_low:
            return ""
        return f"the battery is at {self.percent} %; below {self.limit.low:g} % only the charger is a goal"
