"""Tools of an adapter's author: components as classes, and `run`, which connects them to a gateway.

    from openrois.adapter import Component, command, event, parameter, query, run

`openrois.adapter.components` has a class to extend for each of the standard's basic components; the rest is in
docs/how-to/adapter.md.
"""

from openrois.adapter.command import main
from openrois.adapter.running import run, serve
from openrois.catalog.payload import Data, Payload
from openrois.component.authoring.marks import command, event, optional, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import Component
from openrois.errors import BadParameter, ComponentFailed, OutOfResources, RoISError, TimedOut, Unsupported
from openrois.types.codes import ComponentStatus, ErrorType, StreamStatus

__all__ = [
    "BadParameter",
    "Component",
    "ComponentFailed",
    "ComponentStatus",
    "Data",
    "ErrorType",
    "OutOfResources",
    "Payload",
    "RoISError",
    "StreamStatus",
    "TimedOut",
    "Unsupported",
    "command",
    "event",
    "main",
    "optional",
    "parameter",
    "query",
    "run",
    "serve",
]
