"""What a wheel holds beside its packages: the web page, without which it is refused, and the Godot project."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompleteWheel(BuildHookInterface):
    """Build hook. The page is built by `make page`, never by the wheel; an editable install may be without it."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Stop a standard wheel build when the built page is missing, and put the Godot project into it.

        Args:
            version: `standard` or `editable`, as hatchling names the wheel's form.
            build_data: what hatchling will build.

        Raises:
            RuntimeError: the page has not been built.
        """
        page = Path(self.root, "web_demo", "openrois_web_demo", "static", "index.html")
        if version != "standard":
            return
        if not page.is_file():
            raise RuntimeError(f"{page} is missing: run `make page` before building the wheel")
        godot = str(Path(self.root, "avatar_adapter", "godot"))
        build_data["force_include"][godot] = "openrois_avatar/engines/godot/project"
