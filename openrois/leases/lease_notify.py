"""Telling the adapter of a component which application holds it: what comes past the gateway is for that one alone."""

import logging

from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.errors import RoISError
from openrois.types.streams import HolderNotification

__all__ = ["notify_holder"]

_log = logging.getLogger(__name__)


async def notify_holder(engine: Engine, told: HolderNotification, client: Client) -> None:
    """Tell the engine of a component whether `client` holds it; one that does not want to know is left alone."""
    try:
        await engine.extension.call(told.method, told.model_dump(mode="json"), client)
    except RoISError as error:
        _log.debug("%s is not told who holds it: %s", told.component_ref, error)
