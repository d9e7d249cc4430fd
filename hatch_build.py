"""Refuses a wheel that would ship without the web page; an editable install may still be without it."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class RequirePage(BuildHookInterface):
    """Build hook: the page is built by `make page`, never by the wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Stop a standard wheel build when the built page is missing.

        Args:
            version: `standard` or `editable`, as hatchling names the wheel's form.
            build_data: what hatchling will build; left as it is.

        Raises:
            RuntimeError: the page has not been built.
        """
        page = Path(self.root, "web_demo", "openrois_web_demo", "static", "index.html")
        if version == "standard" and not page.is_file():
            raise RuntimeError(f"{page} is missing: run `make page` before building the wheel")
