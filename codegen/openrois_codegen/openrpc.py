"""OpenRPC 1.3.2: the methods; and in `x-notifications`, for which OpenRPC has no place, the notifications. Pure."""

from typing import Any, Final

from openrois_codegen.ir import Document, Method, Notification, Structure
from openrois_codegen.json_schema import field_schema, schemas, written

__all__ = ["emit"]

_PLACE: Final = "#/components/schemas/"
_ERRORS: Final = {
    "InvalidParams": (-32602, "The params do not fit; `data` lists what is wrong and where."),
    "InternalError": (-32603, "The engine failed."),
}


def emit(document: Document) -> str:
    """Return the OpenRPC document."""
    return written(
        {
            "openrpc": "1.3.2",
            "info": {
                "title": "RoIS 2.0 over JSON-RPC",
                "description": "What an application calls, and is told by a gateway, over WebSocket: one JSON-RPC "
                "object per text frame. A failure in RoIS terms is a result whose `return_code` is not OK. Between a "
                "gateway and its adapters the messages of extensions also carry the `client_id` of the application.",
                "version": document.version,
                "license": {"name": "Apache-2.0"},
            },
            "methods": [_method(document, method) for method in document.methods],
            "x-notifications": [_notification(document, found) for found in document.notifications],
            "components": {
                "schemas": schemas(document, _PLACE),
                "errors": {name: {"code": code, "message": text} for name, (code, text) in _ERRORS.items()},
            },
        }
    )


def _method(document: Document, method: Method) -> dict[str, Any]:
    return {
        **_message(document, method),
        "result": {"name": "result", "required": True, "schema": {"$ref": _PLACE + method.result}},
        "errors": [{"$ref": f"#/components/errors/{name}"} for name in _ERRORS],
        "x-direction": "application to engine",
    }


def _notification(document: Document, notification: Notification) -> dict[str, Any]:
    return {**_message(document, notification), "x-direction": "engine to application"}


def _message(document: Document, message: Method | Notification) -> dict[str, Any]:
    params = document.definitions[message.params]
    assert isinstance(params, Structure)
    return {
        "name": message.name,
        "summary": message.doc,
        "tags": [{"name": message.extension or "base"}],
        "paramStructure": "by-name",
        "params": [
            {"name": field.name, "required": field.required, "schema": field_schema(field, _PLACE)}
            for field in params.fields
        ],
        "x-params": {"$ref": _PLACE + message.params},
        "x-since": message.since,
    }
