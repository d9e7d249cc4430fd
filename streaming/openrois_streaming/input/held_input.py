"""Input that an operator holds now, from messages of which some are lost and some come late. Pure."""

from dataclasses import replace

from openrois_streaming.input.messages import (
    MAX_BUTTONS,
    MAX_KEYS,
    MAX_TOUCHES,
    NOTHING,
    Button,
    Change,
    Gamepad,
    Held,
    Key,
    Message,
    Pad,
    Pointer,
    Release,
    State,
    TouchPoint,
    Wheel,
)

__all__ = ["HeldInput", "changed"]


class HeldInput:
    """Input held at one application. States may be lost and overtake changes; changes come all, and in order.

    `held` is the present input.
    """

    def __init__(self) -> None:
        self.held = NOTHING
        self._newest = -1
        self._last_change = -1

    def apply(self, message: Message) -> bool:
        """Apply a message; False if it is stale: a state that was overtaken, or a change that was applied before.

        A change that was overtaken by a state is in that state already, and still happened.
        """
        if isinstance(message, State):
            if message.seq <= self._newest:
                return False
            self.held = message.held
        else:
            if message.seq <= self._last_change:
                return False
            self._last_change = message.seq
            if message.seq <= self._newest:
                return True
            self.held = changed(self.held, message)
        self._newest = message.seq
        return True

    def clear(self) -> None:
        """Release all input, because the application is gone."""
        self.held = NOTHING


def changed(held: Held, change: Change) -> Held:
    """Return the input after a change; keys and touches beyond the limits of a message are ignored."""
    match change:
        case Key(code=code, down=down):
            keys = held.keys | {code} if down else held.keys - {code}
            return held if len(keys) > MAX_KEYS else replace(held, keys=keys)
        case Button(button=button, down=down, x=x, y=y):
            before = held.pointer.buttons if held.pointer is not None else 0
            bit = _BITS[button]
            return replace(held, pointer=Pointer(x, y, before | bit if down else before & ~bit))
        case Wheel(x=x, y=y):
            return replace(held, pointer=Pointer(x, y, held.pointer.buttons if held.pointer is not None else 0))
        case TouchPoint(down=down, touch=touch):
            others = tuple(each for each in held.touches if each.id != touch.id)
            touches = (*others, touch) if down else others
            return held if len(touches) > MAX_TOUCHES else replace(held, touches=touches)
        case Pad(button=button, down=down):
            pad = held.gamepad or Gamepad()
            buttons = [pad.button(index) for index in range(MAX_BUTTONS)]
            buttons[button] = 1.0 if down else 0.0
            return replace(held, gamepad=replace(pad, buttons=tuple(buttons)))
        case _:
            assert isinstance(change, Release), "there is no other change"
            return NOTHING


_BITS = (1, 4, 2, 8, 16)
"""The bit of `MouseEvent.buttons` for each `MouseEvent.button`: the right one is number 2 and has bit 2."""
