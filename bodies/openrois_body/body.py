"""The body: commands of the components to the game engine, and their outcomes."""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Final

from openrois.aio.rate import RateLimit
from openrois.errors import Aborted, ComponentFailed
from openrois.observability.logs import Tally
from openrois_body.messages import (
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
    """Sends commands to the connected game engine, and awaits their outcomes.

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
        """Movements of the mouth, by the id of each speech that has not ended."""
        self.viewpoint = ""
        """The viewpoint of the pictures; empty for the engine's first one."""
        self._lines = RateLimit(_LINES, _LINES, clock)
        self._unsaid = Tally(_log, "lines of the game engine that are not logged")

    async def react(self, reaction: str) -> None:
        """Play a reaction to its end; cancelling this stops it.

        Raises:
            Aborted: another reaction replaced it, or it was stopped.
            ComponentFailed: the game engine is disconnected, or could not play it.
        """
        reaction_id = secrets.token_hex(8)
        done: asyncio.Future[Completed] = asyncio.get_running_loop().create_future()
        self._reactions[reaction_id] = done
        try:
            self._send_command(React(reaction_id, reaction))
            completed = await done
        except asyncio.CancelledError:
            self._send_if_connected(Stop(reaction_id))
            raise
        finally:
            del self._reactions[reaction_id]
        if completed.status == "ABORT":
            raise Aborted(completed.reason or f"{reaction} was stopped")
        if completed.status == "ERROR":
            raise ComponentFailed(completed.reason or f"the body could not play {reaction}")

    def speak(self, speech_id: str, movements: Iterable[Speak]) -> None:
        """Move the mouth until `spoken` or `silence`; a game engine that connects later moves it too.

        Without a game engine nothing moves, and the voice is heard all the same.
        """
        self._movements[speech_id] = tuple(movements)
        for movement in self._movements[speech_id]:
            self._send_if_connected(movement)

    def spoken(self, speech_id: str) -> None:
        """Forget the mouth movements of a speech that has ended."""
        self._movements.pop(speech_id, None)

    def silence(self) -> None:
        """Close the mouth now, and forget the movements of every speech."""
        self._movements.clear()
        self._send_if_connected(Silence())

    def engine_returned(self, viewpoints: Sequence[str]) -> None:
        """Resume mouth movements and viewpoint on a game engine that has connected again.

        Args:
            viewpoints: the names that this engine offers; another engine may offer others or none.
        """
        if self.viewpoint in viewpoints:
            self._send_if_connected(Viewpoint(self.viewpoint))
        for movements in tuple(self._movements.values()):
            for movement in movements:
                self._send_if_connected(movement)

    def turn_eyes(self, x: float, y: float) -> None:
        """Turn the eyes: x from -1 (the viewer's left) to 1, y from -1 (down) to 1.

        Raises:
            ComponentFailed: the game engine is gone.
        """
        self._send_command(Look(x, y))

    def show_from(self, viewpoint: str) -> None:
        """Show the figure from one of the engine's viewpoints, also on an engine that connects later.

        Raises:
            ComponentFailed: the game engine is gone.
        """
        self._send_command(Viewpoint(viewpoint))
        self.viewpoint = viewpoint

    def handle_event(self, event: Event) -> None:
        """Handle an event of the game engine: the outcome of a reaction, or a log line."""
        match event:
            case Completed(id=reaction_id):
                done = self._reactions.get(reaction_id)
                if done is not None and not done.done():
                    done.set_result(event)
            case Log(text=text) if self._lines.admits():
                _log.info("game engine: %s", " / ".join(text.splitlines()))
            case Log():
                self._unsaid.note()

    def engine_lost(self) -> None:
        """Fail the running reactions: the game engine is disconnected."""
        for done in self._reactions.values():
            if not done.done():
                done.set_exception(ComponentFailed("the body is disconnected; try again when it is back"))

    def _send_command(self, command: Command) -> None:
        try:
            self._send(command)
        except LinkError as error:
            raise ComponentFailed(str(error)) from error

    def _send_if_connected(self, command: Command) -> None:
        try:
            self._send(command)
        except LinkError as error:
            _log.debug("a command was not sent to the game engine: %s", error)
