"""The generated files, and the function that makes each."""

from pathlib import Path
from typing import Final

from openrois_conformance.manifest import read_manifest
from openrois_conformance.table import as_markdown

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.schema import VERSION
from openrois_codegen import (
    corpus,
    csharp,
    csharp_components,
    json_schema,
    openrpc,
    python_bases,
    python_proxies,
    typescript,
    typescript_checks,
    values,
)
from openrois_codegen.by_hand import by_hand
from openrois_codegen.wire import document

__all__ = ["GENERATED", "targets"]

GENERATED: Final = (
    f"openrois/schema/{VERSION}/*",
    f"tests/corpus/{VERSION}/**/*",
    "sdk/csharp/Runtime/OpenRoIS/Generated/*.cs",
    "web_demo/sdk/rois/generated/*",
)
"""Where nothing stands but what is generated."""

_PAGE: Final = "docs/reference/conformance.md"
_MADE_BY: Final = "<!-- made by: openrois conformance --markdown -->"
"""Of a page that is written by hand, what stands after this line is generated."""


def targets(root: Path) -> dict[str, str]:
    """Return the text of every generated file by its path in the repository.

    Args:
        root: the repository, for what is only generated in part.
    """
    found = document()
    folder = f"openrois/schema/{found.version}"
    messages = corpus.emit(found, by_hand())
    return {
        **{f"tests/corpus/{found.version}/{name}": text for name, text in messages.items()},
        f"tests/corpus/{found.version}/values/values.json": values.emit(),
        f"{folder}/rois.schema.json": json_schema.emit(found),
        f"{folder}/openrpc.json": openrpc.emit(found),
        "openrois/adapter/components.py": python_bases.emit(BASIC_COMPONENTS),
        "openrois/client/components.py": python_proxies.emit(BASIC_COMPONENTS),
        "sdk/csharp/Runtime/OpenRoIS/Generated/Types.cs": csharp.types(found),
        "sdk/csharp/Runtime/OpenRoIS/Generated/Methods.cs": csharp.methods(found),
        "sdk/csharp/Runtime/OpenRoIS/Generated/Payloads.cs": csharp_components.payloads(found),
        "sdk/csharp/Runtime/OpenRoIS/Generated/Components.cs": csharp_components.components(found),
        "web_demo/sdk/rois/generated/types.ts": typescript.types(found),
        "web_demo/sdk/rois/generated/methods.ts": typescript.methods(found),
        "web_demo/sdk/rois/generated/components.ts": typescript.components(found),
        "web_demo/sdk/rois/generated/checks.ts": typescript_checks.emit(found),
        _PAGE: _page(root / _PAGE),
    }


def _page(path: Path) -> str:
    written = path.read_text(encoding="utf-8") if path.is_file() else ""
    head, _, _ = written.partition(_MADE_BY)
    return "\n".join([f"{head}{_MADE_BY}", "", *as_markdown(read_manifest()), ""])
