"""Running a command unit sequence: one item after another, the commands of a concurrent item side by side."""

import asyncio
import sys
from collections.abc import Awaitable, Callable, Sequence
from typing import Final

from openrois.types.codes import CompletedStatus
from openrois.types.messages import CommandUnit, ConcurrentCommands, SequenceItem

__all__ = ["OVERHEAD", "commands_of", "run_sequence", "size_of"]

OVERHEAD: Final = 512
"""Bytes that an item, a command or an argument takes beside its texts: very many empty ones fill a memory, too."""

_MILLISECOND: Final = 0.001


def commands_of(items: Sequence[SequenceItem]) -> list[CommandUnit]:
    """Return every command of a sequence, in order."""
    return [unit for item in items for unit in (item.command_list if isinstance(item, ConcurrentCommands) else (item,))]


def size_of(items: Sequence[SequenceItem]) -> int:
    """Return how many bytes a sequence takes as long as it is kept."""
    size = OVERHEAD * len(items)
    for unit in commands_of(items):
        size += OVERHEAD * (1 + len(unit.arguments))
        size += sum(map(sys.getsizeof, (unit.component_ref, unit.command_type, unit.command_id)))
        for argument in unit.arguments:
            size += sum(map(sys.getsizeof, (argument.name, argument.data_type_ref, argument.value)))
    return size


async def run_sequence(
    items: Sequence[SequenceItem],
    run: Callable[[CommandUnit], Awaitable[CompletedStatus]],
    skip: Callable[[CommandUnit, CompletedStatus], None],
    sleep: Callable[[float], Awaitable[None]],
) -> None:
    """Run a sequence to its end.

    An item's `delay_time` passes before it starts; the commands of a concurrent item start together, each after its own
    delay, and the next item waits for all of them. Once a command ends with anything but OK, no later item runs.

    Args:
        items: what was accepted.
        run: runs one command and says how it ended; must not raise.
        skip: called for each command that will not run because an earlier one failed, and with how that one ended.
        sleep: waits for some seconds.
    """
    for index, item in enumerate(items):
        status = await _run_item(item, run, sleep)
        if status is not CompletedStatus.OK:
            for unit in commands_of(items[index + 1 :]):
                skip(unit, status)
            return


async def _run_item(
    item: SequenceItem,
    run: Callable[[CommandUnit], Awaitable[CompletedStatus]],
    sleep: Callable[[float], Awaitable[None]],
) -> CompletedStatus:
    """Run an item and return how it ended: as the first of its commands that did not end OK, if there is one."""

    async def run_delayed(unit: CommandUnit) -> CompletedStatus:
        await _delay(unit.delay_time, sleep)
        return await run(unit)

    if isinstance(item, CommandUnit):
        return await run_delayed(item)
    await _delay(item.delay_time, sleep)
    async with asyncio.TaskGroup() as tasks:
        running = [tasks.create_task(run_delayed(unit)) for unit in item.command_list]
    failed = (task.result() for task in running if task.result() is not CompletedStatus.OK)
    return next(failed, CompletedStatus.OK)


async def _delay(milliseconds: int | None, sleep: Callable[[float], Awaitable[None]]) -> None:
    if milliseconds:
        await sleep(milliseconds * _MILLISECOND)
