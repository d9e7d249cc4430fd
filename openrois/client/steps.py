"""Steps: commands that are not sent yet. Awaited they run alone; put together they run as one sequence."""

import warnings
from collections.abc import Awaitable, Callable, Generator, Iterator
from typing import Any, Generic, Protocol, TypeVar

from openrois.client.commands import Command, Execution
from openrois.types.messages import Argument, CommandUnit

__all__ = ["Concurrent", "Executor", "Step", "concurrent", "no_step"]

T = TypeVar("T")


class Executor(Protocol):
    """Runs steps: a client."""

    async def execute(self, *items: Any) -> Execution:
        """Send a sequence; returns once it was accepted."""
        ...


class Step(Generic[T]):
    """One command, not sent yet. It can be run any number of times.

    * `await step` runs it to its end and returns what it gave; it raises as `Command` does.
    * `command = await step.execute()` returns once the gateway has accepted it.
    * `await client.run(step, other)` runs several in order, `concurrent(step, other)` at the same time.
    """

    def __init__(
        self,
        executor: Executor,
        component_ref: str,
        command_type: str,
        prepare: Callable[[], Awaitable[tuple[Argument, ...]]],
        read: Callable[[str], Awaitable[T]],
        delay: float | None = None,
    ) -> None:
        self._executor = executor
        self._component_ref = component_ref
        self._command_type = command_type
        self._prepare = prepare
        self._read = read
        self._delay = delay
        self._used = False

    def __repr__(self) -> str:
        return f"<Step {self._command_type} of {self._component_ref}>"

    def __del__(self) -> None:
        if not getattr(self, "_used", True):
            # As of a coroutine: the robot does nothing, and without a warning the cause stays hidden.
            warnings.warn(f"{self!r} was never run: await it", RuntimeWarning, stacklevel=2, source=self)

    def used(self) -> None:
        """Note that it is going to be run: whether that succeeds is told by an error."""
        self._used = True

    def after(self, seconds: float) -> "Step[T]":
        """Return the same step, begun this many seconds after its turn has come."""
        self.used()
        return Step(self._executor, self._component_ref, self._command_type, self._prepare, self._read, seconds)

    async def execute(self) -> Command[T]:
        """Send it and return its handle once the gateway has accepted it.

        Raises:
            RoISError: it was refused: unknown, not bound, or with arguments that do not fit.
            ConnectionLost: there is no connection.
            TimeoutError: no answer in time.
        """
        execution = await self._executor.execute(self)
        return execution.commands[0]

    def __await__(self) -> Generator[Any, None, T]:
        return self._run().__await__()

    async def _run(self) -> T:
        return await (await self.execute())

    async def prepare(self, command_id: str) -> tuple[CommandUnit, Command[T]]:
        """Return the unit to send and the handle of the command that it will be."""
        unit = CommandUnit(
            component_ref=self._component_ref,
            command_type=self._command_type,
            command_id=command_id,
            arguments=await self._prepare(),
            delay_time=_milliseconds(self._delay),
        )
        return unit, Command(self._component_ref, self._command_type, command_id, self._read)


class Concurrent:
    """Steps that run at the same time; the next step of the sequence waits for all of them."""

    def __init__(self, steps: tuple[Step[Any], ...], delay: float | None = None) -> None:
        self._steps = steps
        self._delay = delay

    def after(self, seconds: float) -> "Concurrent":
        """Return the same steps, begun this many seconds after their turn has come; each may have its own delay too."""
        return Concurrent(self._steps, seconds)

    def used(self) -> None:
        """Note that they are going to be run."""
        for step in self._steps:
            step.used()

    def __iter__(self) -> Iterator[Step[Any]]:
        return iter(self._steps)

    @property
    def delay_time(self) -> int | None:
        """The delay as the wire has it: milliseconds."""
        return _milliseconds(self._delay)


def concurrent(*steps: Step[Any]) -> Concurrent:
    """Put steps side by side: `await client.run(concurrent(nav.start(), speech.start()))`.

    Raises:
        TypeError: one is no step.
    """
    wrong = [step for step in steps if not isinstance(step, Step)]
    if wrong:
        for step in steps:
            if isinstance(step, Step | Concurrent):
                # The error tells; a warning of each step that does not run would only hide it.
                step.used()
        raise no_step("concurrent", wrong[0])
    return Concurrent(steps)


def no_step(taker: str, given: object) -> TypeError:
    """Return the error for a value given in place of a step: mostly what awaiting one returned."""
    return TypeError(f"{taker} takes steps, such as navigation.start() without await, not {type(given).__name__}")


def _milliseconds(seconds: float | None) -> int | None:
    return None if seconds is None else round(seconds * 1000)
