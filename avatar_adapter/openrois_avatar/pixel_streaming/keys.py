"""The deprecated key numbers of browsers (`KeyboardEvent.keyCode`), and their keys (`KeyboardEvent.code`). Pure.

They name what a key means on the layout of its keyboard; the place of the key is that of the US layout. Some numbers
differ between browsers, and right-hand keys have numbers that Pixel Streaming made up.
"""

from collections.abc import Mapping
from typing import Final

__all__ = ["CODES"]

_SINGLE: Final[Mapping[int, str]] = {
    8: "Backspace",
    9: "Tab",
    13: "Enter",
    16: "ShiftLeft",
    17: "ControlLeft",
    18: "AltLeft",
    19: "Pause",
    20: "CapsLock",
    27: "Escape",
    32: "Space",
    33: "PageUp",
    34: "PageDown",
    35: "End",
    36: "Home",
    37: "ArrowLeft",
    38: "ArrowUp",
    39: "ArrowRight",
    40: "ArrowDown",
    44: "PrintScreen",
    45: "Insert",
    46: "Delete",
    59: "Semicolon",
    61: "Equal",
    91: "MetaLeft",
    92: "MetaRight",
    93: "ContextMenu",
    106: "NumpadMultiply",
    107: "NumpadAdd",
    109: "NumpadSubtract",
    110: "NumpadDecimal",
    111: "NumpadDivide",
    144: "NumLock",
    145: "ScrollLock",
    173: "Minus",
    186: "Semicolon",
    187: "Equal",
    188: "Comma",
    189: "Minus",
    190: "Period",
    191: "Slash",
    192: "Backquote",
    219: "BracketLeft",
    220: "Backslash",
    221: "BracketRight",
    222: "Quote",
    226: "IntlBackslash",
    253: "ShiftRight",
    254: "ControlRight",
    255: "AltRight",
}

CODES: Final[Mapping[int, str]] = {
    **_SINGLE,
    **{48 + digit: f"Digit{digit}" for digit in range(10)},
    **{65 + letter: f"Key{chr(65 + letter)}" for letter in range(26)},
    **{96 + digit: f"Numpad{digit}" for digit in range(10)},
    **{112 + number: f"F{number + 1}" for number in range(12)},
}
"""`KeyboardEvent.code` by `keyCode`."""
