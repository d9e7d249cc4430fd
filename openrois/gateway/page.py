"""The web demo's files, read from the package that carries them."""

import mimetypes
from typing import Final

from aiohttp import web
from openrois_web_demo import static_files

__all__ = ["page_response"]

_HEADERS: Final = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": (
        "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data: blob:; media-src 'self' blob:; "
        "style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

_NOT_BUILT: Final = "The web demo has not been built in this checkout: run `make page`, then reload.\n"


def page_response(path: str) -> web.Response:
    """Answer a GET of one of the page's files; the empty path is the page itself.

    Raises:
        web.HTTPNotFound: there is no such file.
    """
    files = {entry.name: entry for entry in static_files().iterdir() if entry.is_file()} if _is_there() else {}
    if "index.html" not in files:
        raise web.HTTPServiceUnavailable(text=_NOT_BUILT)
    name = path or "index.html"
    if name not in files:
        raise web.HTTPNotFound(text="there is nothing here\n")
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    charset = "utf-8" if kind.startswith("text/") or kind.endswith(("javascript", "json")) else None
    return web.Response(body=files[name].read_bytes(), content_type=kind, charset=charset, headers=_HEADERS)


def _is_there() -> bool:
    return static_files().is_dir()
