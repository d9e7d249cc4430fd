"""The avatar's body: what the components ask of the game engine, and how they learn that it was done."""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Final

from openrois.aio.rate import RateLimit
from openrois.errors import Aborted, ComponentFailed
from openrois.observability.logs import Tally
from openrois_avatar.link.messages import (
    Command,
    Completed,
    Event,
    LinkError,
    Log,
    Look,
    React,
    Silence,
    Speak,
    Stop,
    Viewpoint,
)

__all__ = ["Body"]

_log = logging.getLogger(__name__)

_LINES: Final = 20
"""Lines of an engine that are logged each second; of the others only the number."""


class Body:
    """Commands to whichever game engine is connected now.

    Args:
        send: sends a command to it.
        clock: monotonic seconds.

    Raises:
        LinkError: out of `send`, while no game engine is connected.
    """

    def __init__(self, send: Callable[[Command], None], clock: Callable[[], float] = time.monotonic) -> None:
        self._send = send
        self._reactions: dict[str, asyncio.Future[Completed]] = {}
        self._movements: dict[str, tuple[Speak, ...]] = {}
        """Of the mouth, for the speeches that are not over."""
        self.viewpoint = ""
        """From where the pictures are to show it; empty for where the game engine begins."""
        self._lines = RateLimit(_LINES, _LINES, clock)
        self._unsaid = Tally(_log, "lines of the game engine that are not logged")

    async def react(self, reaction: str) -> None:
        """Play a reaction to its end; cancelling it stops the avatar.

        Raises:
            Aborted: another reaction replaced it, or it was stopped.
            ComponentFailed: the game engine is gone or could not do it.
        """
        reaction_id = secrets.token_hex(8)
        done: asyncio.Future[Completed] = asyncio.get_running_loop().create_future()
        self._reactions[reaction_id] = done
        try:
            self._tell(React(reaction_id, reaction))
            completed = await done
        except asyncio.CancelledError:
            self._tell_if_there(Stop(reaction_id))
            raise
        finally:
            del self._reactions[reaction_id]
        if completed.status == "ABORT":
            raise Aborted(f"{reaction} was stopped")
        if completed.status == "ERROR":
            raise ComponentFailed(f"the game engine could not play {reaction}")

    def speak(self, speech_id: str, movements: Iterable[Speak]) -> None:
        """Move the mouth, until it has `spoken` or is to be in `silence`; a game engine that comes later moves it too.

        Without a game engine nothing moves, and the voice is heard all the same.
        """
        self._movements[speech_id] = tuple(movements)
        for movement in self._movements[speech_id]:
            self._tell_if_there(movement)

    def spoken(self, speech_id: str) -> None:
        """Know that a speech is over."""
        self._movements.pop(speech_id, None)

    def silence(self) -> None:
        """Close the mouth now, whatever it was to say."""
        self._movements.clear()
        self._tell_if_there(Silence())

    def back(self, viewpoints: Sequence[str]) -> None:
        """A game engine is there again: its mouth goes on with what is being said, and its camera where it was.

        Args:
            viewpoints: the names that it offers; it may be another engine, which knows others or none.
        """
        if self.viewpoint in viewpoints:
            self._tell_if_there(Viewpoint(self.viewpoint))
        for movements in tuple(self._movements.values()):
            for movement in movements:
                self._tell_if_there(movement)

    def look(self, x: float, y: float) -> None:
        """Turn the eyes: x from -1 (the viewer's left) to 1, y from -1 (down) to 1.

        Raises:
            ComponentFailed: the game engine is gone.
        """
        self._tell(Look(x, y))

    def show_from(self, viewpoint: str) -> None:
        """Show the figure from one of the engine's viewpoints; one that comes later shows it from there, too.

        Raises:
            ComponentFailed: the game engine is gone.
        """
        self._tell(Viewpoint(viewpoint))
        self.viewpoint = viewpoint

    def take(self, event: Event) -> None:
        """Take an event of the game engine."""
        match event:
            case Completed(id=reaction_id):
                done = self._reactions.get(reaction_id)
                if done is not None and not done.done():
                    done.set_result(event)
            case Log(text=text) if self._lines.admits():
                _log.info("game engine: %s", " / ".join(text.splitlines()))
            case Log():
                self._unsaid.note()

    def lost(self) -> None:
        """The game engine is gone: whatever it was doing has failed."""
        for done in self._reactions.values():
            if not done.done():
                done.set_exception(ComponentFailed("the game engine is gone"))

    def _tell(self, command: Command) -> None:
        try:
            self._send(command)
        except LinkError as error:
            raise ComponentFailed(str(error)) from error

    def _tell_if_there(self, command: Command) -> None:
        try:
            self._send(command)
        except LinkError as error:
            _log.debug("not said to the game engine: %s", error)
