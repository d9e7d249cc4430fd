"""Leaves out what a language model thinks before it speaks, where its server does not take that away. Pure."""

from typing import Final

__all__ = ["Thoughts"]

_BEGIN: Final = "<think>"
_END: Final = "</think>"


class Thoughts:
    """Tells thoughts, which stand at the beginning of a text that arrives in pieces, from what is meant to be said."""

    def __init__(self) -> None:
        self._rest = ""
        self._is_thinking = False
        self._is_over = False

    def leave_out(self, text: str) -> str:
        """Return what of more text is no thought."""
        if self._is_over:
            return text
        self._rest += text
        if not self._is_thinking:
            begun = self._rest.lstrip()
            if begun.startswith(_BEGIN):
                self._is_thinking, self._rest = True, begun.removeprefix(_BEGIN)
            elif _BEGIN.startswith(begun):
                # It may become one.
                return ""
            else:
                self._is_over = True
                return self._rest
        _, end, said = self._rest.partition(_END)
        self._is_over = bool(end)
        self._rest = self._rest[-len(_END) :]
        return said
