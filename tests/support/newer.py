"""What a program of the next minor version says: whatever this one does, and more."""

import json
from typing import Any, Final
from unittest.mock import _patch, patch

from openrois.jsonrpc.session import RpcSession

__all__ = ["newer_text", "speaking_newer", "with_more"]

_MORE: Final = {"of": ["the", "next"], "minor": 1}
_MAPS: Final = frozenset({"component_profiles", "profiles", "used"})
"""Members that have what they are about for names."""


def with_more(said: Any, *, is_map: bool = False) -> Any:
    """Return JSON with one more member in each of its objects."""
    if isinstance(said, list):
        return [with_more(each) for each in said]
    if not isinstance(said, dict):
        return said
    more = {name: with_more(value, is_map=name in _MAPS) for name, value in said.items()}
    return more if is_map else {**more, "more": _MORE}


def newer_text(text: str) -> str:
    """Return a message of JSON-RPC as a newer program writes it: results and notifications say more, requests do not.

    What is about media stays as it is: signaling is an extension with a version of its own.
    """
    message = json.loads(text)
    if "result" in message:
        message["result"] = with_more(message["result"])
    elif "id" not in message and not message.get("method", "signaling.").startswith("signaling."):
        message["params"] = with_more(message.get("params", {}))
    return json.dumps(message)


def speaking_newer() -> "_patch[Any]":
    """Return a patch by which every session of this process writes its messages as a newer program does."""
    put = RpcSession._put

    def put_newer(session: RpcSession, text: str, *, droppable: bool = False) -> None:
        put(session, newer_text(text), droppable=droppable)

    return patch.object(RpcSession, "_put", put_newer)
