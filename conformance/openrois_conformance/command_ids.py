"""Ids of commands as checks write them and as they are sent: no other check, and no other run, uses the same. Pure."""

import secrets
from typing import Any

__all__ = ["CommandIds"]


class CommandIds:
    """The ids of one check: a gateway may remember those of earlier ones, of other applications, too."""

    def __init__(self) -> None:
        self._suffix = secrets.token_hex(16)
        self._sent: dict[str, str] = {}
        self._written: dict[str, str] = {}

    def sent(self, command_id: str) -> str:
        """Return the id that stands on the wire for one of the check's; any other is returned as it is."""
        return self._sent.get(command_id, command_id)

    def written(self, command_id: str) -> str:
        """Return the check's id for one of the wire; any other is returned as it is."""
        return self._written.get(command_id, command_id)

    def outgoing(self, params: dict[str, Any]) -> dict[str, Any]:
        """Return params with the ids of the wire; what has no place for ids, or has something else there, is kept."""
        changed = dict(params)
        if isinstance(units := params.get("command_unit_list"), list):
            changed["command_unit_list"] = [self._unit(unit) for unit in units]
        if isinstance(command_id := params.get("command_id"), str):
            changed["command_id"] = self.sent(command_id)
        if isinstance(command_ids := params.get("command_ids"), list):
            changed["command_ids"] = [self.sent(each) for each in command_ids]
        return changed

    def _unit(self, unit: Any) -> Any:
        if not isinstance(unit, dict):
            return unit
        if isinstance(branch := unit.get("command_list"), list):
            return {**unit, "command_list": [self._unit(each) for each in branch]}
        command_id = unit.get("command_id")
        if not isinstance(command_id, str) or not command_id:
            return unit
        wire_id = self._sent.setdefault(command_id, f"{command_id}-{self._suffix}")
        self._written[wire_id] = command_id
        return {**unit, "command_id": wire_id}

    def incoming(self, params: dict[str, Any]) -> dict[str, Any]:
        """Return params or a result with the check's ids."""
        changed = dict(params)
        if isinstance(command_id := params.get("command_id"), str):
            changed["command_id"] = self.written(command_id)
        if isinstance(forgotten := params.get("forgotten"), list | tuple):
            changed["forgotten"] = [self.written(each) for each in forgotten]
        return changed
