"""Where lines and what they hold are kept: the contract of a store, which gateways share. Pure."""

from collections.abc import Iterable
from typing import Final, Protocol

from openrois.resumption.lines import Change, Holding, Redemption

__all__ = ["KEPT_FOR", "MAX_PRUNED", "ResumeStore"]

KEPT_FOR: Final = 86_400.0
"""Seconds without a touch after which a line is removed, with all that it holds."""

MAX_PRUNED: Final = 64
"""Lines that one `issue` removes at most, and components that one `write` removes; so that none of them takes long."""


class ResumeStore(Protocol):
    """What is asked of a store. Each method is one step that happens whole or not at all, and none is repeated.

    A line is an application's session over all its connections: `line_id` is random and stays when the session is
    resumed; `generation` is 0 at first, and one more with each resumption. Tokens come as SHA-256 digests alone.

    Each may raise `StoreUnreachable`, within about a second; then it is not known whether the step was made.

    Attributes:
        name: of the store, for sentences; without credentials.
    """

    name: str

    async def issue(self, line_id: str, generation: int, subject: str, digest: bytes, *, rank: str = "") -> bool:
        """Make a digest the good one of a line, which begins where it is not known; the former one counts as spent.

        The rank is that of the session's principal now: what the line holds is kept for a session of this rank.

        Returns:
            False where the line was resumed since, that is has a greater generation, or was revoked. The session that
            asks is over then.
        """
        ...

    async def redeem(self, digest: bytes, subject: str) -> Redemption:
        """Use up a token: its line goes on with the next generation, and has no good token until one is issued.

        A token that is shown a second time revokes its line: what the line holds is freed, and no token of it is good.
        """
        ...

    async def touch(self, line_ids: Iterable[str]) -> None:
        """Keep lines whose sessions are still there for another while; unknown ones are left out."""
        ...

    async def end_line(self, line_id: str, generation: int) -> None:
        """Remove a line, because its session has left for good: what it holds is freed, and its tokens are unknown.

        Nothing happens where it was resumed since, and so has a greater generation.
        """
        ...

    async def write(self, changes: Iterable[Change]) -> None:
        """Write which components are held and freed; of a component a change with a smaller epoch changes nothing."""
        ...

    async def held(self, engine_ids: Iterable[str]) -> tuple[Holding, ...]:
        """Return which components of these engines are held by lines that are known and not revoked, in their order."""
        ...
