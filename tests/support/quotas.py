"""The session of an application, as far as quotas see it."""

from dataclasses import dataclass, field

__all__ = ["Session"]


@dataclass(eq=False)
class Session:
    """Stands in for the session of an application."""

    quota_name: str
    streams: list[str] = field(default_factory=list)
    connecting: int = 0
    is_relayed: bool = False
