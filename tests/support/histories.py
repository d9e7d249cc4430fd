"""What adapters and applications saw while gateways failed, and its judgement. Pure.

Adapters say what their fences saw, applications what they were told. Epochs decide who held a component: clocks and
what gateways took for true do not.

F23  a component never has two holders: a greater epoch ends the smaller ones, and what runs has the greatest
F24  an epoch belongs to one application for ever, over all its connections
I2   each accepted command gets exactly one `completed`: no application leaves before. Where the journal was lost, or
     away when a gateway was, the SDK may say instead that its end is lost
I11  a command runs once at most, not after its end was told, and where it ended OK it did run
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import chain

__all__ = ["LATE", "Accepted", "Completed", "Connected", "Held", "History", "Lost", "Ran", "judge"]

LATE = 2.0
"""Seconds after the end of a command was told in which it may still begin: a gateway that knew of it was lost then."""


@dataclass(frozen=True, slots=True)
class Connected:
    """An application was told by which id adapters know it over this connection."""

    at: float
    application: str
    client_id: str


@dataclass(frozen=True, slots=True)
class Held:
    """An adapter was told that an application holds a component, or holds it no more; its fence let that pass."""

    at: float
    component_ref: str
    epoch: int
    client_id: str
    holds: bool


@dataclass(frozen=True, slots=True)
class Ran:
    """An adapter began a command; `epoch` is that of the holder whom the gateway that sent it had told, 0 for none."""

    at: float
    component_ref: str
    epoch: int
    command: str


@dataclass(frozen=True, slots=True)
class Accepted:
    """An application was told that its command is accepted."""

    at: float
    application: str
    command: str


@dataclass(frozen=True, slots=True)
class Completed:
    """An application was told how its command ended."""

    at: float
    application: str
    command: str
    status: str


@dataclass(frozen=True, slots=True)
class Lost:
    """An application was told by its SDK that the end of its command cannot be known any more."""

    at: float
    application: str
    command: str


Entry = Connected | Held | Ran | Accepted | Completed | Lost


@dataclass
class History:
    """Entries of all adapters and applications of one run, by one clock, in any order."""

    entries: list[Entry] = field(default_factory=list)

    def add(self, entry: Entry) -> None:
        """Add an entry."""
        self.entries.append(entry)

    def told(self) -> list[str]:
        """Return all entries in the order of time, a line each, for the reader of a failed run."""
        return [repr(entry) for entry in sorted(self.entries, key=lambda entry: entry.at)]


def judge(history: History, *, may_forget: bool = False, late: float = LATE) -> list[str]:
    """Return what is wrong with a history, a line each; none where all holds.

    Args:
        history: what adapters and applications saw.
        may_forget: the journal was away with the gateway that ran a command: its end may be that it is lost.
        late: seconds after the end of a command was told in which it may still begin.
    """
    by_time = sorted(history.entries, key=lambda entry: entry.at)
    wrong = (_two_holders(by_time), _shared_epochs(by_time), _ends(by_time), _endless(by_time, may_forget=may_forget))
    return [*chain.from_iterable(wrong), *_runs(by_time, late)]


def _two_holders(entries: Iterable[Entry]) -> Iterable[str]:
    greatest: dict[str, int] = defaultdict(int)
    for entry in entries:
        match entry:
            case Held(at, ref, epoch, client, True) if epoch < greatest[ref]:
                yield f"{at:.3f}: {client} holds {ref} by epoch {epoch}, behind {greatest[ref]} (F23)"
            case Held(_, ref, epoch, _, True):
                greatest[ref] = epoch
            case Ran(at, ref, 0, command):
                yield f"{at:.3f}: {command} runs at {ref} for no holder (F23)"
            case Ran(at, ref, epoch, command) if epoch < greatest[ref]:
                yield f"{at:.3f}: {command} runs at {ref} by epoch {epoch}, behind {greatest[ref]} (F23)"
            case _:
                pass


def _shared_epochs(entries: Iterable[Entry]) -> Iterable[str]:
    told = list(entries)
    names = {entry.client_id: entry.application for entry in told if isinstance(entry, Connected)}
    holders: dict[tuple[str, int], str] = {}
    for entry in told:
        if isinstance(entry, Held):
            name = names.get(entry.client_id, entry.client_id)
            former = holders.setdefault((entry.component_ref, entry.epoch), name)
            if former != name:
                yield (
                    f"{entry.at:.3f}: epoch {entry.epoch} of {entry.component_ref} is that of {former}, "
                    f"and then of {name} (F24)"
                )


def _ends(entries: Iterable[Entry]) -> Iterable[str]:
    accepted: set[str] = set()
    ends: dict[str, list[str]] = defaultdict(list)
    for entry in entries:
        match entry:
            case Accepted(_, _, command):
                accepted.add(command)
            case Completed(_, _, command, status):
                ends[command].append(status)
            case Lost(_, _, command):
                ends[command].append("lost")
            case _:
                pass
    for command, statuses in ends.items():
        if len(statuses) > 1:
            yield f"{command} ended {len(statuses)} times: {', '.join(statuses)} (I2)"
        if command not in accepted:
            yield f"{command} ended {statuses[0]} and was not accepted (I2)"


def _endless(entries: Iterable[Entry], *, may_forget: bool) -> Iterable[str]:
    told = list(entries)
    ended = {
        entry.command for entry in told if isinstance(entry, Completed) or (may_forget and isinstance(entry, Lost))
    }
    for entry in told:
        if isinstance(entry, Accepted) and entry.command not in ended:
            yield f"{entry.at:.3f}: {entry.command} of {entry.application} was accepted and has no end (I2)"


def _runs(entries: Iterable[Entry], allowed: float) -> Iterable[str]:
    ran: dict[str, float] = {}
    ended: dict[str, Completed] = {}
    for entry in entries:
        if isinstance(entry, Ran):
            end = ended.get(entry.command)
            if entry.command in ran:
                yield f"{entry.at:.3f}: {entry.command} runs again (I11)"
            late = 0.0 if end is None else entry.at - end.at
            if end is not None and late > allowed:
                yield f"{entry.at:.3f}: {entry.command} runs {late:.1f} s after it ended {end.status} (I11)"
            ran.setdefault(entry.command, entry.at)
        elif isinstance(entry, Completed):
            ended.setdefault(entry.command, entry)
    for command, end in ended.items():
        if end.status == "OK" and command not in ran:
            yield f"{end.at:.3f}: {command} ended OK and never ran (I11)"
