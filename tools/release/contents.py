"""Required and forbidden contents of the archives of a release."""

import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

__all__ = ["PAGE", "missing_page", "read_archive"]

PAGE: Final = "openrois_web_demo/static/index.html"


def read_archive(archive: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the path and the content of every file of a wheel or an sdist; an sdist's own folder is left out."""
    if archive.suffix == ".whl":
        with zipfile.ZipFile(archive) as wheel:
            for name in wheel.namelist():
                yield name, wheel.read(name)
        return
    with tarfile.open(archive) as sdist:
        for member in sdist:
            if (file := sdist.extractfile(member)) is not None:
                yield member.name.partition("/")[2], file.read()


def missing_page(archive: Path) -> str:
    """Return what to do where an archive has no web page; empty where it has one."""
    if any(name.endswith(PAGE) for name, _ in read_archive(archive)):
        return ""
    return f"{archive.name} has no web page: run `make page` first"
