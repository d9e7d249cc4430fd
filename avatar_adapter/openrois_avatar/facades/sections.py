"""The m-sections of descriptions that pass between game engine and application. Pure.

The text of a description is never changed, except for the candidates of an answer, which are removed and checked one by
one. An application may receive exactly the streams that it has connected, and send none.
"""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from openrois_signaling.messages import MID_LIMIT, SECTIONS_LIMIT

__all__ = [
    "CandidateLine",
    "Section",
    "UnusableDescription",
    "check_answer",
    "section_for",
    "sections_of",
    "split_candidates",
]

Way: TypeAlias = Literal["sendrecv", "sendonly", "recvonly", "inactive"]
"""The direction of a section, seen from the author of the description."""

_WAYS: Final[tuple[Way, ...]] = ("sendrecv", "sendonly", "recvonly", "inactive")
_MEDIA: Final = re.compile(r"m=([a-z]{1,16}) (\d{1,5})(?:/\d{1,5})? \S{1,32}(?: \S{1,64}){1,64}")
_LINE: Final = re.compile(r"[a-z]=[^\x00-\x1f]*")


class UnusableDescription(Exception):
    """A description that cannot be used; the text is a sentence for a person without parts of the description."""


@dataclass(frozen=True, slots=True)
class Section:
    """An m-section. `way` is seen from the author; a `rejected` section is not used."""

    kind: str
    mid: str
    way: Way
    rejected: bool

    @property
    def gives(self) -> bool:
        """Whether the author sends in it."""
        return not self.rejected and self.way in {"sendrecv", "sendonly"}


@dataclass(frozen=True, slots=True)
class CandidateLine:
    """A candidate attribute of the section with this mid and index."""

    candidate: str
    mid: str
    index: int


def sections_of(sdp: str) -> tuple[Section, ...]:
    """Return the sections of a description, in order.

    Raises:
        UnusableDescription: it is no SDP, or has no sections, too many, or two with one mid.
    """
    session, blocks = _blocks(sdp)
    usual = _way(session, "sendrecv")
    found = tuple(_section(lines, usual) for lines in blocks)
    if not 0 < len(found) <= SECTIONS_LIMIT:
        raise UnusableDescription(f"the description must have 1 to {SECTIONS_LIMIT} sections, not {len(found)}")
    if len({section.mid for section in found}) < len(found):
        raise UnusableDescription("the description has two sections with one mid")
    return found


def section_for(kind: str, offered: Sequence[Section]) -> Section | None:
    """Return the section in which a game engine sends its picture or sound; None if it sends none."""
    return next((section for section in offered if section.kind == kind and section.gives), None)


def check_answer(answer: str, offered: Sequence[Section], connected: Collection[str]) -> None:
    """Check that an answer receives exactly the connected streams, and sends none.

    Args:
        answer: the application's description.
        offered: the sections of the game engine's offer.
        connected: the mids of the sections with streams of the application.

    Raises:
        UnusableDescription: it does not match the offer, or receives or sends other streams.
    """
    answered = sections_of(answer)
    if [(each.kind, each.mid) for each in answered] != [(each.kind, each.mid) for each in offered]:
        raise UnusableDescription("the answer has other sections than the offer")
    for section in answered:
        if section.mid not in connected:
            if not section.rejected and section.way != "inactive":
                raise UnusableDescription(f"section {section.mid} was not connected: it must be answered inactive")
        elif section.rejected or section.way != "recvonly":
            raise UnusableDescription(f"section {section.mid} is connected: it must be answered recvonly")


def split_candidates(sdp: str) -> tuple[str, tuple[CandidateLine, ...]]:
    """Return a description without its candidates, and the candidates."""
    kept: list[str] = []
    found: list[CandidateLine] = []
    sections = sections_of(sdp)
    index = -1
    for line in sdp.splitlines(keepends=True):
        index += line.startswith("m=")
        if index >= 0 and line.startswith("a=candidate:"):
            found.append(CandidateLine(line.strip().removeprefix("a="), sections[index].mid, index))
        else:
            kept.append(line)
    return "".join(kept), tuple(found)


def _blocks(sdp: str) -> tuple[list[str], list[list[str]]]:
    session: list[str] = []
    media: list[list[str]] = []
    for line in sdp.replace("\r\n", "\n").removesuffix("\n").split("\n"):
        if not _LINE.fullmatch(line):
            raise UnusableDescription("the description is not SDP")
        if line.startswith("m="):
            media.append([])
        (media[-1] if media else session).append(line)
    return session, media


def _section(lines: Sequence[str], usual: Way) -> Section:
    line = _MEDIA.fullmatch(lines[0])
    mids = [each.removeprefix("a=mid:").strip() for each in lines if each.startswith("a=mid:")]
    if line is None or len(mids) != 1 or not 0 < len(mids[0]) <= MID_LIMIT:
        raise UnusableDescription("the description has a section without a media type or mid")
    bundled = "a=bundle-only" in lines
    return Section(line[1], mids[0], _way(lines, usual), rejected=int(line[2]) == 0 and not bundled)


def _way(lines: Sequence[str], otherwise: Way) -> Way:
    return next((way for way in _WAYS if f"a={way}" in lines), otherwise)
