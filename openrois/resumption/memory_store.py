"""Lines and holdings in the memory of one process: what a gateway uses that is alone. Pure."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice

from openrois.resumption.lines import Change, Held, Holding, Line, Redemption, last_changes
from openrois.resumption.store import KEPT_FOR, MAX_PRUNED

__all__ = ["MemoryResumeStore"]


@dataclass(frozen=True, slots=True)
class _Kept:
    """What is kept of a component: the line that holds it, which is empty where it is free."""

    engine_id: str
    line_id: str
    epoch: int
    touched: float


class MemoryResumeStore:
    """A `ResumeStore` of dictionaries and a clock.

    Args:
        clock: seconds of any origin.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.name = "the memory of this gateway"
        self._clock = clock
        self._lines: dict[str, Line] = {}
        self._touched: dict[str, float] = {}
        """When each line was touched, the oldest first."""
        self._line_ids: dict[bytes, str] = {}
        self._kept: dict[str, _Kept] = {}
        """What is kept of each component, the oldest first."""

    async def issue(self, line_id: str, generation: int, subject: str, digest: bytes, *, rank: str = "") -> bool:
        """Make a digest the good one of a line."""
        line = self._lines.get(line_id, Line(subject, generation)).issued(generation, subject, digest, rank)
        if line is None or self._line_ids.get(digest, line_id) != line_id:
            return False
        self._put(line_id, line)
        self._prune_lines()
        return True

    async def redeem(self, digest: bytes, subject: str) -> Redemption:
        """Use up a token."""
        line_id = self._line_ids.get(digest, "")
        former = self._lines.get(line_id)
        if former is None or former.subject != subject:
            return Redemption()
        line = former.redeemed(digest)
        self._put(line_id, line)
        if line.is_revoked:
            self._free(line_id)
        return Redemption(line_id, line.generation, line.is_revoked)

    async def touch(self, line_ids: Iterable[str]) -> None:
        """Keep lines for another while."""
        for line_id in line_ids:
            if line_id in self._lines:
                self._touch(line_id)

    async def end_line(self, line_id: str, generation: int) -> None:
        """Remove a line."""
        line = self._lines.get(line_id)
        if line is not None and line.generation <= generation:
            self._remove(line_id)
            self._free(line_id)

    async def write(self, changes: Iterable[Change]) -> None:
        """Write which components are held and freed."""
        now = self._clock()
        for component_ref, change in last_changes(changes).items():
            former = self._kept.get(component_ref)
            if former is None or change.epoch >= former.epoch:
                holder = (change.engine_id, change.line_id) if isinstance(change, Held) else ("", "")
                self._keep(component_ref, _Kept(*holder, change.epoch, now))
        self._prune_components(now)

    async def held(self, engine_ids: Iterable[str]) -> tuple[Holding, ...]:
        """Return which components of these engines are held."""
        wanted, found = set(engine_ids), []
        for component_ref, kept in sorted(self._kept.items()):
            line = self._lines.get(kept.line_id)
            if line is not None and not line.is_revoked and kept.engine_id in wanted:
                found.append(Holding(component_ref, kept.engine_id, kept.line_id, kept.epoch, line.subject, line.rank))
        return tuple(found)

    def _put(self, line_id: str, line: Line) -> None:
        former = self._lines.get(line_id)
        for digest in () if former is None else former.spent:
            del self._line_ids[digest]
        self._lines[line_id] = line
        good = () if line.good is None else (line.good,)
        self._line_ids |= dict.fromkeys((*line.spent, *good), line_id)
        self._touch(line_id)

    def _touch(self, line_id: str) -> None:
        self._touched.pop(line_id, None)
        self._touched[line_id] = self._clock()

    def _keep(self, component_ref: str, kept: _Kept) -> None:
        self._kept.pop(component_ref, None)
        self._kept[component_ref] = kept

    def _remove(self, line_id: str) -> None:
        line = self._lines.pop(line_id, None)
        if line is not None:
            for digest in (*line.spent, line.good):
                if digest is not None:
                    del self._line_ids[digest]
            del self._touched[line_id]

    def _free(self, line_id: str) -> None:
        """Free what a line holds. Epochs are kept, so that what comes late changes nothing."""
        now = self._clock()
        for component_ref, kept in tuple(self._kept.items()):
            if kept.line_id == line_id:
                self._keep(component_ref, _Kept("", "", kept.epoch, now))

    def _prune_lines(self) -> None:
        oldest = list(islice(self._touched.items(), MAX_PRUNED))
        for line_id, touched in oldest:
            if touched < self._clock() - KEPT_FOR:
                self._remove(line_id)

    def _prune_components(self, now: float) -> None:
        oldest = list(islice(self._kept.items(), MAX_PRUNED))
        for component_ref, kept in oldest:
            if kept.touched < now - KEPT_FOR:
                if kept.line_id in self._lines:
                    self._keep(component_ref, _Kept(kept.engine_id, kept.line_id, kept.epoch, now))
                else:
                    del self._kept[component_ref]
