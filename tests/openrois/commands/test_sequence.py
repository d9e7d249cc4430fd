"""The order in which the commands of a sequence run, on a clock that is turned by hand."""

import asyncio
from collections.abc import Sequence

from openrois.commands.sequence import OVERHEAD, commands_of, run_sequence, size_of
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Argument, CommandUnit, ConcurrentCommands, SequenceItem


def unit(name: str, delay: int | None = None) -> CommandUnit:
    return CommandUnit(component_ref="r/lamp", command_type="switch", command_id=name, delay_time=delay)


def at_once(*units: CommandUnit, delay: int | None = None) -> ConcurrentCommands:
    return ConcurrentCommands(command_list=units, delay_time=delay)


class Clock:
    """Time that passes when every task waits for it, straight to the next deadline."""

    def __init__(self) -> None:
        self.now = 0.0
        self._sleepers: list[tuple[float, asyncio.Event]] = []

    async def sleep(self, seconds: float) -> None:
        woken = asyncio.Event()
        self._sleepers.append((self.now + seconds, woken))
        await woken.wait()

    async def run(self, work: asyncio.Future[None]) -> None:
        while not work.done():
            for _ in range(10):
                await asyncio.sleep(0)
            if self._sleepers:
                self.now = min(at for at, _ in self._sleepers)
                due = [entry for entry in self._sleepers if entry[0] <= self.now]
                self._sleepers = [entry for entry in self._sleepers if entry[0] > self.now]
                for _, woken in due:
                    woken.set()
        await work


class Journal:
    """Runs commands that take a time of their own and notes what happened when (in milliseconds)."""

    def __init__(self, takes: dict[str, float] | None = None, ends: dict[str, CompletedStatus] | None = None) -> None:
        self.clock = Clock()
        self.notes: list[tuple[int, str]] = []
        self._takes = takes or {}
        self._ends = ends or {}

    def _note(self, text: str) -> None:
        self.notes.append((round(self.clock.now * 1000), text))

    async def _run(self, command: CommandUnit) -> CompletedStatus:
        name = command.command_id
        self._note(f"{name} starts")
        if name in self._takes:
            await self.clock.sleep(self._takes[name] / 1000)
        self._note(f"{name} ends")
        return self._ends.get(name, CompletedStatus.OK)

    async def play(self, *items: SequenceItem) -> list[tuple[int, str]]:
        work = run_sequence(
            items,
            self._run,
            lambda skipped, status: self._note(f"{skipped.command_id} skipped: {status}"),
            self.clock.sleep,
        )
        await self.clock.run(asyncio.ensure_future(work))
        return self.notes


async def test_one_after_another_each_after_its_delay() -> None:
    assert await Journal(takes={"a": 100}).play(unit("a", 20), unit("b", 0), unit("c", 5)) == [
        (20, "a starts"),
        (120, "a ends"),
        (120, "b starts"),
        (120, "b ends"),
        (125, "c starts"),
        (125, "c ends"),
    ]


async def test_concurrent_commands_start_together_and_the_next_item_waits_for_all() -> None:
    journal = Journal(takes={"a": 100, "b": 10})
    assert await journal.play(at_once(unit("a"), unit("b", 30), delay=5), unit("c")) == [
        (5, "a starts"),
        (35, "b starts"),
        (45, "b ends"),
        (105, "a ends"),
        (105, "c starts"),
        (105, "c ends"),
    ]


async def test_whatever_is_not_ok_stops_what_follows() -> None:
    for status in CompletedStatus:
        if status is not CompletedStatus.OK:
            journal = Journal(ends={"a": status})
            assert await journal.play(unit("a"), unit("b", 50), at_once(unit("c"), unit("d"))) == [
                (0, "a starts"),
                (0, "a ends"),
                (0, f"b skipped: {status}"),
                (0, f"c skipped: {status}"),
                (0, f"d skipped: {status}"),
            ]


async def test_a_failure_lets_its_concurrent_neighbours_end_first() -> None:
    journal = Journal(takes={"b": 10}, ends={"a": CompletedStatus.ERROR})
    assert await journal.play(at_once(unit("a"), unit("b"), unit("c", 20)), unit("d")) == [
        (0, "a starts"),
        (0, "a ends"),
        (0, "b starts"),
        (10, "b ends"),
        (20, "c starts"),
        (20, "c ends"),
        (20, "d skipped: ERROR"),
    ]


async def test_an_empty_item_takes_its_delay_and_no_more() -> None:
    assert await Journal().play(at_once(delay=40), unit("a")) == [(40, "a starts"), (40, "a ends")]


def test_commands_in_order() -> None:
    items: Sequence[SequenceItem] = (unit("a"), at_once(unit("b"), unit("c")), at_once(), unit("d"))
    assert [command.command_id for command in commands_of(items)] == ["a", "b", "c", "d"]


def test_what_is_kept_of_a_sequence() -> None:
    """Everything in it counts, and wide characters count as what they take."""

    def told(value: str) -> CommandUnit:
        argument = Argument(name="how", data_type_ref="string", value=value)
        return unit("a").model_copy(update={"arguments": (argument,)})

    empty = size_of((told(""),))
    assert empty > 3 * OVERHEAD
    assert size_of((told("x" * 1000),)) == empty + 1000
    assert size_of((told("\N{GRINNING FACE}" * 1000),)) >= empty + 4000
    assert size_of((at_once(told(""), told("")),)) == 2 * empty - OVERHEAD
    assert size_of((at_once(), at_once(), told(""))) == empty + 2 * OVERHEAD
