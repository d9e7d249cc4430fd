"""Shows at a body how a mind converses: where words go, what can be said, and the wake word."""

import logging
from collections.abc import Sequence
from typing import Final

from openrois.client import ConnectionLost, RoISError, RpcError
from openrois.types.profiles import component_urn
from openrois_agents.tools.held_body import HeldBody

__all__ = ["DIALOGUE", "show_dialogue"]

_log = logging.getLogger(__name__)

DIALOGUE: Final = component_urn("Dialogue", "OpenRoIS")
_EXAMPLES: Final = 20
_LONGEST: Final = 80


async def show_dialogue(held: HeldBody, sent_to: str, can_be_said: Sequence[str], wake_word: str) -> None:
    """Set what a body shows of a conversation, where it shows such; it forgets that when the body is given back."""
    for component_ref in held.info.refs(DIALOGUE)[:1]:
        examples = [each for each in can_be_said if each and len(each) <= _LONGEST]
        try:
            component = await held.bind(component_ref)
            await component.set_parameter(sent_to=sent_to, can_be_said=tuple(examples[:_EXAMPLES]), wake_word=wake_word)
        except (ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.warning("%s does not show what can be said, and where words go: %s", held.engine_id, error)
