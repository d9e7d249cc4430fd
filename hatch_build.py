"""Contents of distributions beside their packages: the web page, the Godot project, and a description for indexes."""

import re
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

_LINK = re.compile(r"(!?\[[^\]]*\]\()(?![a-z]+:|#)([^)\s]+)\)")
_VERSION = re.compile(r'^__version__ = "([^"]+)"$', re.MULTILINE)


class DistributionContents(BuildHookInterface):
    """Build hook. The page is built by `make page`, never here: a gateway without it says that it has none."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Warn when the page has not been built, and put the Godot project into a standard wheel.

        Args:
            version: `standard` or `editable`, as hatchling names a form; an editable wheel reads the checkout.
            build_data: what hatchling will build.
        """
        if version != "standard":
            return
        if not Path(self.root, "web_demo", "openrois_web_demo", "static", "index.html").is_file():
            self.app.display_warning(f"This {self.target_name} has no web page: run `make page` first to include it.")
        if self.target_name == "wheel":
            godot = str(Path(self.root, "avatar_adapter", "godot"))
            build_data["force_include"][godot] = "openrois_avatar/engines/godot/project"


class Description(MetadataHookInterface):
    """Metadata hook: the README as the long description, whose links lead into the repository from anywhere."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set `readme`.

        Args:
            metadata: the `[project]` table.
        """
        source = metadata["urls"]["Source"]
        found = _VERSION.search(Path(self.root, "openrois", "version.py").read_text(encoding="utf-8"))
        if found is None:
            raise ValueError("openrois/version.py has no line with __version__")
        text = Path(self.root, "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {
            "content-type": "text/markdown",
            "text": _LINK.sub(lambda link: f"{link[1]}{_address(source, f'v{found[1]}', link)})", text),
        }


def _address(source: str, tag: str, link: "re.Match[str]") -> str:
    """Return where a file of the repository is read: a picture itself, and a page with what is around it."""
    kind = "raw" if link[1].startswith("!") else "blob"
    return f"{source}/{kind}/{tag}/{link[2]}"
