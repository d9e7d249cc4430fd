"""The web demo's files, read from the package that carries them."""

import mimetypes
from importlib.resources.abc import Traversable
from typing import Final

from aiohttp import web
from openrois_web_demo import static_files

__all__ = ["NO_PAGE", "has_page", "page_response"]

_HEADERS: Final = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": (
        "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data: blob:; media-src 'self' blob:; "
        "style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

NO_PAGE: Final = "this gateway was installed without a web page: run `make page` in a clone and install it from there"


def page_response(path: str) -> web.Response:
    """Answer a GET of one of the page's files; the empty path is the page itself.

    Raises:
        web.HTTPNotFound: there is no such file.
        web.HTTPServiceUnavailable: the page has not been built.
    """
    files = _files()
    if "index.html" not in files:
        raise web.HTTPServiceUnavailable(text=f"{NO_PAGE}\n")
    name = path or "index.html"
    if name not in files:
        raise web.HTTPNotFound(text="there is no such page\n")
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    charset = "utf-8" if kind.startswith("text/") or kind.endswith(("javascript", "json")) else None
    return web.Response(body=files[name].read_bytes(), content_type=kind, charset=charset, headers=_HEADERS)


def has_page() -> bool:
    """Tell whether the page has been built."""
    return "index.html" in _files()


def _files() -> dict[str, Traversable]:
    folder = static_files()
    return {entry.name: entry for entry in folder.iterdir() if entry.is_file()} if folder.is_dir() else {}
