"""`python -m tools.pages`: writes the printed parts of all pages, or with `--check` names the pages out of date."""

import argparse
import sys
from pathlib import Path
from typing import Final

from tools.pages.bodies import bodies
from tools.pages.commands import commands
from tools.pages.configuration import gateway_settings
from tools.pages.figures import adapter_figures, cluster_figures, gateway_figures, mind_figures
from tools.pages.parts import Part, filled, outdated
from tools.pages.scale import (
    scale_compared,
    scale_costs,
    scale_needs,
    scale_others,
    scale_saturation,
    scale_streams,
    scale_wire,
)
from tools.pages.states import negotiation_states, stream_states

__all__ = ["PARTS", "ROOT", "pages"]

ROOT: Final = Path(__file__).parents[2]

PARTS: Final[dict[str, Part]] = {
    "adapter-figures": adapter_figures,
    "cluster-figures": cluster_figures,
    "bodies": bodies,
    "commands": commands,
    "gateway-figures": gateway_figures,
    "mind-figures": mind_figures,
    "gateway-settings": gateway_settings,
    "negotiation-states": negotiation_states,
    "scale-compared": scale_compared,
    "scale-costs": scale_costs,
    "scale-needs": scale_needs,
    "scale-others": scale_others,
    "scale-saturation": scale_saturation,
    "scale-streams": scale_streams,
    "scale-wire": scale_wire,
    "stream-states": stream_states,
}
"""Every printed part by the name that its mark has."""


def pages(root: Path = ROOT) -> dict[str, str]:
    """Return every page with printed parts, as it has to be."""
    candidates = (root / "ARCHITECTURE.md", *sorted((root / "docs").rglob("*.md")))
    texts = {path: path.read_text(encoding="utf-8") for path in candidates}
    return {
        path.relative_to(root).as_posix(): filled(text, PARTS)
        for path, text in texts.items()
        if "<!-- printed: " in text
    }


def main() -> None:
    """Write or check."""
    parser = argparse.ArgumentParser(prog="python -m tools.pages", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; name the pages that are out of date")
    wanted = parser.parse_args()
    stale = outdated(ROOT, found := pages())
    if wanted.check:
        sys.exit(f"run `make generate`: out of date are {', '.join(stale)}" if stale else 0)
    for path in stale:
        (ROOT / path).write_text(found[path], encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
