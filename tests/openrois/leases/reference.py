"""The simplest thing that could be right about leases: of each part a stack of sessions and a line of those that wait.

The session on top of a stack holds the part; those below have lent it, each to the next one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

LAMP, WALK, DRIVE = "r/lamp", "r/walk", "r/drive"
LEGS = "r//legs"
MEMBERS = {LAMP: (LAMP,), LEGS: (WALK, DRIVE)}
REFS = (LAMP, WALK, DRIVE)


class BodyParts:
    """A lamp, and legs that walk and drive."""

    def part_of(self, component_ref: str) -> str:
        return LEGS if component_ref in MEMBERS[LEGS] else component_ref

    def members(self, part: str, holder: object) -> tuple[str, ...]:
        return MEMBERS[part]


@dataclass(eq=False)
class Session:
    """One application, or another that has come in its place."""

    number: int
    token: str = ""
    away_until: float | None = None
    is_latched: bool = False

    def __repr__(self) -> str:
        return f"session {self.number}"


@dataclass(eq=False)
class Standing:
    """What a session has of a part, which of it by name, and until when it may have it."""

    session: Session
    refs: set[str]
    named: set[str]
    until: float = math.inf
    for_one: bool = False


@dataclass
class Part:
    """One part: who has it, from whom, and who waits."""

    stack: list[Standing] = field(default_factory=list)
    line: list[tuple[Session, str]] = field(default_factory=list)

    def holder(self) -> Session | None:
        return self.stack[-1].session if self.stack else None

    def waiting(self) -> list[Session]:
        return [session for session, _ in self.line]

    def drop_waiting(self, session: Session) -> None:
        self.line = [each for each in self.line if each[0] is not session]

    def drop_below(self, which: Callable[[Standing], bool]) -> None:
        self.stack = [each for each in self.stack if each is self.stack[-1] or not which(each)]


class Reference:
    """All parts."""

    def __init__(self) -> None:
        self.parts = {name: Part() for name in MEMBERS}

    def part(self, ref: str) -> Part:
        return self.parts[BodyParts().part_of(ref)]

    def holder(self, ref: str) -> Session | None:
        """The session that holds the component itself."""
        part = self.part(ref)
        return part.holder() if part.stack and ref in part.stack[-1].refs else None

    def members(self, ref: str) -> set[str]:
        return set(MEMBERS[BodyParts().part_of(ref)])

    def bind(self, ref: str, session: Session) -> bool:
        part = self.part(ref)
        if not part.stack:
            part.stack = [Standing(session, set(), set())]
        if part.holder() is session:
            part.stack[-1].refs.add(ref)
            part.stack[-1].named.add(ref)
        return part.holder() is session

    def release(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        for standing in [each for each in part.stack if each.session is session]:
            standing.refs.discard(ref)
            standing.named.discard(ref)
        if part.holder() is session and not part.stack[-1].named:
            self.end(part)
        part.drop_below(lambda each: not each.named)

    def hand_back(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        if part.holder() is session:
            self.end(part)

    def end(self, part: Part) -> None:
        """The holder has it no more: the one that lent it does, or the first in line."""
        part.stack.pop()
        while part.stack and part.stack[-1].session.is_latched:
            part.stack.pop()
        if not part.stack and part.line:
            name = next(name for name, each in self.parts.items() if each is part)
            session, ref = part.line.pop(0)
            part.stack = [Standing(session, set(MEMBERS[name]), {ref})]

    def request(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        if not part.stack:
            part.stack = [Standing(session, set(), set())]
        if part.holder() is session:
            part.stack[-1].refs = self.members(ref)
            part.stack[-1].named.add(ref)
        elif session not in part.waiting():
            part.line.append((session, ref))

    def withdraw(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        part.drop_waiting(session)

    def promote(self, ref: str, session: Session) -> None:
        """The holder lets another have what it has; a lender gets back what it had."""
        part = self.part(ref)
        self.withdraw(ref, session)
        if any(each.session is session for each in part.stack[:-1]):
            while part.holder() is not session:
                part.stack.pop()
        else:
            part.stack[-1].session = session
        part.stack[-1].refs, part.stack[-1].named = self.members(ref), {ref}

    def take(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        if part.holder() in (None, session):
            self.request(ref, session)
            return
        self.promote(ref, session)
        part.stack = [Standing(session, self.members(ref), {ref})]

    def borrow(self, ref: str, session: Session, until: float, for_one: bool) -> None:
        part = self.part(ref)
        if part.holder() in (None, session):
            self.request(ref, session)
            if part.stack[-1].until < math.inf:
                part.stack[-1].until, part.stack[-1].for_one = until, for_one
            return
        self.withdraw(ref, session)
        part.drop_below(lambda each: each.session is session)
        part.stack.append(Standing(session, self.members(ref), {ref}, until, for_one))

    def finish(self, ref: str, session: Session) -> None:
        part = self.part(ref)
        if part.holder() is session and part.stack[-1].for_one:
            self.end(part)

    def lose(self, session: Session) -> None:
        """Its connection is lost, and it has a token: it keeps what is its own, and what it has lent."""
        for part in self.parts.values():
            part.drop_waiting(session)
            if part.holder() is session and part.stack[-1].until < math.inf:
                self.end(part)

    def forget(self, session: Session) -> None:
        for part in self.parts.values():
            part.drop_waiting(session)
            part.drop_below(lambda each: each.session is session)
            if part.holder() is session:
                self.end(part)

    def end_loans(self, now: float) -> None:
        for part in self.parts.values():
            part.drop_below(lambda each: each.until <= now)
            while part.stack and part.stack[-1].until <= now:
                self.end(part)

    def replace(self, former: Session, successor: Session) -> None:
        for part in self.parts.values():
            part.drop_waiting(former)
            for standing in part.stack:
                if standing.session is former:
                    standing.session = successor
            if part.holder() is successor:
                part.drop_waiting(successor)
