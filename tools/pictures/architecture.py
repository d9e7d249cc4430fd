"""`python -m tools.pictures.architecture`: draws the picture of ARCHITECTURE.md, with the packages of each part."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final, Literal

from tools.pictures.record import FOLDER, ROOT, write_record

__all__ = ["PACKAGES", "draw", "main"]

Flow = Literal["control", "media"]

_WIDTH, _HEIGHT = 960, 436
_COLOURS: Final[dict[Flow, str]] = {"control": "#2f6fb3", "media": "#c2562f"}
_LABEL: Final = (
    "Service applications speak JSON-RPC to the gateway; adapters of avatars and robots stand behind it; "
    "media flows straight from the avatar adapter to the browser."
)


@dataclass(frozen=True, slots=True)
class Part:
    """A box inside a process: what it does, and the packages that it is.

    Attributes:
        top: distance from the top of the picture.
        height: of the box.
        words: lines of text.
        packages: names that are imported, shown below the words.
    """

    top: int
    height: int
    words: tuple[str, ...]
    packages: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Process:
    """A program of its own, with its place in the picture."""

    left: int
    top: int
    width: int
    height: int
    title: str
    words: tuple[str, ...]
    parts: tuple[Part, ...]


@dataclass(frozen=True, slots=True)
class Arrow:
    """A connection between two processes, with words above it."""

    flow: Flow
    y: int
    start: int
    end: int
    words: tuple[tuple[int, int, str], ...] = ()
    both: bool = True


PROCESSES: Final = (
    Process(
        28, 24, 232, 390, "Service application", ("the web demo, its inspector,", "your page, your program"),
        (
            Part(128, 108, ("RoIS client (Python or", "TypeScript): components,", "commands, events"), ("openrois",)),
            Part(330, 68, ("media receiver, in a", "browser: picture, sound")),
        ),
    ),
    Process(
        396, 24, 196, 294, "Gateway", ("the main HRI engine",),
        (
            Part(90, 104, ("engine of engines,", "sessions, leases"), ("openrois",)),
            Part(204, 46, ("relay of signaling",), ("openrois_signaling",)),
            Part(260, 46, ("the demo's page",), ("openrois_web_demo",)),
        ),
    ),
    Process(
        702, 24, 230, 112, "Your adapter", ("a sub HRI engine: a robot ...",),
        (Part(86, 40, ("components are classes",), ("openrois",)),),
    ),
    Process(
        702, 150, 230, 264, "Avatar adapter", ("a sub HRI engine",),
        (
            Part(210, 46, ("speech, reactions, walks",), ("openrois_avatar",)),
            Part(260, 46, ("senses, operation by hand",), ("openrois_body",)),
            Part(310, 32, ("game engine, a child",)),
            Part(346, 62, ("encoded once for all",), ("openrois_media", "openrois_streaming")),
        ),
    ),
)  # fmt: skip

ARROWS: Final = (
    Arrow("control", 196, 264, 392, ((274, 164, "RoIS messages"), (274, 182, "JSON-RPC, ws /"))),
    Arrow("control", 106, 596, 698),
    Arrow(
        "control", 246, 596, 698, ((602, 160, "the same wire,"), (602, 178, "ws /adapter;"), (602, 196, "they dial in"))
    ),
    Arrow("media", 384, 698, 264, ((306, 372, "WebRTC: live video and audio, straight from the adapter"),), both=False),
)

PACKAGES: Final = tuple(name for process in PROCESSES for part in process.parts for name in part.packages)


def draw() -> str:
    """Return the picture as SVG.

    Raises:
        LookupError: a package of the picture is not in the tree.
    """
    if absent := sorted({name for name in PACKAGES if not any(ROOT.glob(f"**/{name}/__init__.py"))}):
        raise LookupError(f"no package is called {absent[0]}: correct PROCESSES in tools/pictures/architecture.py")
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}"'
        f' font-family="system-ui, sans-serif" role="img" aria-label="{escape(_LABEL)}">',
        "<defs>",
        *(_marker(flow) for flow in _COLOURS),
        "</defs>",
        _box(0, 0, _WIDTH, _HEIGHT, 14, "#f8fafc"),
        *(line for process in PROCESSES for line in _process(process)),
        *(line for arrow in ARROWS for line in _arrow(arrow)),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _marker(flow: Flow) -> str:
    return (
        f'<marker id="{flow}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6"'
        f' orient="auto-start-reverse"><path d="M0 0L8 4L0 8z" fill="{_COLOURS[flow]}"/></marker>'
    )


def _process(process: Process) -> Sequence[str]:
    left, width = process.left, process.width
    lines = [
        _box(left, process.top, width, process.height, 12, "#ffffff", "#3d4f6b"),
        _text(left + 18, process.top + 30, process.title, "#1b2840", size=17, weight=600),
        *(_text(left + 18, process.top + 50 + 17 * at, words, "#44536b") for at, words in enumerate(process.words)),
    ]
    for part in process.parts:
        lines.append(_box(left + 18, part.top, width - 36, part.height, 8, "#eef3fa", "#9db0cc"))
        first = part.top + (part.height - 17 * (len(part.words) + len(part.packages))) // 2 + 13
        for at, words in enumerate(part.words):
            lines.append(_text(left + 30, first + 17 * at, words, "#44536b"))
        for at, name in enumerate(part.packages, len(part.words)):
            lines.append(_text(left + 30, first + 17 * at, name, "#6b7c96", mono=True))
    return lines


def _arrow(arrow: Arrow) -> Sequence[str]:
    colour = _COLOURS[arrow.flow]
    both = f' marker-start="url(#{arrow.flow})"' if arrow.both else ""
    return [
        f'<path d="M{arrow.start} {arrow.y}H{arrow.end}" stroke="{colour}" stroke-width="2" fill="none"'
        f'{both} marker-end="url(#{arrow.flow})"/>',
        *(_text(x, y, words, colour) for x, y, words in arrow.words),
    ]


def _box(x: int, y: int, width: int, height: int, radius: int, fill: str, stroke: str = "") -> str:
    edge = f' stroke="{stroke}"' if stroke else ""
    return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" fill="{fill}"{edge}/>'


def _text(x: int, y: int, words: str, fill: str, *, size: int = 13, weight: int = 400, mono: bool = False) -> str:
    family = ' font-family="ui-monospace, monospace" font-size="11"' if mono else f' font-size="{size}"'
    bold = f' font-weight="{weight}"' if weight != 400 else ""
    return f'<text x="{x}" y="{y}"{family}{bold} fill="{fill}">{escape(words)}</text>'


def main() -> None:
    """Write the picture."""
    (FOLDER / "architecture.svg").write_text(draw(), encoding="utf-8")
    write_record(["architecture.svg"])


if __name__ == "__main__":
    main()
