"""Error codes of the simulated robot, and their texts. They are its own: a real robot tells the vendor's. Pure."""

import json
from enum import IntEnum
from typing import Final

__all__ = ["ErrorCode", "error_code_json"]


class ErrorCode(IntEnum):
    """What went wrong."""

    NONE = 0
    CANCELLED = 10001
    UNKNOWN_TARGET = 10002
    NO_WAY = 10003
    BLOCKED = 10004
    NO_SHELF = 10005
    UNSUPPORTED = 10006
    EMERGENCY_STOP = 20001
    EMPTY_BATTERY = 20002
    MANUAL_CONTROL_OFF = 20003
    COMMAND_RUNS = 20004
    MANUAL_CONTROL_ON = 20005


_TEXTS: Final = {
    ErrorCode.CANCELLED: ("Cancelled", "The command was cancelled."),
    ErrorCode.UNKNOWN_TARGET: ("Unknown target", "There is no such location or shelf on the map."),
    ErrorCode.NO_WAY: ("No way", "There is no way to the destination."),
    ErrorCode.BLOCKED: ("Blocked", "Something is in the way."),
    ErrorCode.NO_SHELF: ("No shelf", "The robot carries no shelf."),
    ErrorCode.UNSUPPORTED: ("Not simulated", "The simulated robot does not carry out this command."),
    ErrorCode.EMERGENCY_STOP: ("Emergency stop", "The emergency stop is active."),
    ErrorCode.EMPTY_BATTERY: ("Battery empty", "Charge the robot."),
    ErrorCode.MANUAL_CONTROL_OFF: ("Manual control is off", "Enable manual control first."),
    ErrorCode.COMMAND_RUNS: ("Command running", "Manual control is not available while a command runs."),
    ErrorCode.MANUAL_CONTROL_ON: ("Manual control is on", "Commands are not taken during manual control."),
}


def error_code_json() -> str:
    """Return all codes as the robot tells them."""
    return json.dumps(
        [
            {
                "code": int(code),
                "error_type": "Error",
                "title": title,
                "description": description,
                "title_en": title,
                "description_en": description,
                "ref_url": "",
            }
            for code, (title, description) in _TEXTS.items()
        ]
    )
