"""`python -m tools.pictures.architecture`: draws the picture of ARCHITECTURE.md, with the packages of each part."""

from dataclasses import dataclass
from typing import Final, Literal

from openrois_bench.charts.svg import COLOURS, INK, Drawing

from tools.pictures.record import FOLDER, ROOT, write_record

__all__ = ["PACKAGES", "draw", "main"]

Flow = Literal["control", "media"]

_WIDTH, _HEIGHT = 960, 436
_COLOURS: Final[dict[Flow, str]] = {"control": COLOURS["ours"], "media": COLOURS["aiortc"]}
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
            Part(250, 66, ("tools for agents:", "openrois mcp"), ("openrois_agents",)),
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
        702, 24, 230, 112, "Robots, your adapter", (),
        (Part(64, 62, ("components are classes",), ("openrois", "openrois_robots")),),
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
    drawing = Drawing(_WIDTH, _HEIGHT, _LABEL)
    for process in PROCESSES:
        _draw_process(drawing, process)
    for arrow in ARROWS:
        drawing.arrow(arrow.start, arrow.y, arrow.end, _COLOURS[arrow.flow], both=arrow.both)
        for x, y, words in arrow.words:
            drawing.text(x, y, words, fill=_COLOURS[arrow.flow])
    return str(drawing)


def _draw_process(drawing: Drawing, process: Process) -> None:
    left, width = process.left, process.width
    drawing.box(left, process.top, width, process.height, "#ffffff", radius=12, stroke="#3d4f6b")
    drawing.text(left + 18, process.top + 30, process.title, fill=INK, size=17, bold=True)
    for at, words in enumerate(process.words):
        drawing.text(left + 18, process.top + 50 + 17 * at, words)
    for part in process.parts:
        drawing.box(left + 18, part.top, width - 36, part.height, "#eef3fa", radius=8, stroke="#9db0cc")
        first = part.top + (part.height - 17 * (len(part.words) + len(part.packages))) // 2 + 13
        for at, words in enumerate(part.words):
            drawing.text(left + 30, first + 17 * at, words)
        for at, name in enumerate(part.packages, len(part.words)):
            drawing.text(left + 30, first + 17 * at, name, fill="#6b7c96", size=11, code=True)


def main() -> None:
    """Write the picture."""
    (FOLDER / "architecture.svg").write_text(draw(), encoding="utf-8")
    write_record(["architecture.svg"])


if __name__ == "__main__":
    main()
