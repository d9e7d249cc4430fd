"""The ids under which commands are sent to another engine."""

from openrois.commands.history import MAX_ID
from openrois.remote.commands import MAX_USED, MAX_USED_TEXT, RemoteCommand, RemoteCommands


def commands() -> RemoteCommands:
    return RemoteCommands(lambda: None)


def test_an_id_is_sent_once() -> None:
    ours = commands()
    assert ours.id_for("c") == "c"
    again, third = ours.id_for("c"), ours.id_for("c")
    assert again != third
    for other in (again, third):
        assert other.startswith("c-")
        assert len(other) == 2 + 32


def test_where_none_is_wanted_or_a_suffix_has_no_room_the_id_is_random() -> None:
    ours, long = commands(), "x" * MAX_ID
    assert len(ours.id_for("")) == 32
    assert ours.id_for(long) == long
    assert len(ours.id_for(long)) == 32
    shorter = "x" * (MAX_ID - 33)
    assert ours.id_for(shorter) == shorter
    assert len(ours.id_for(shorter)) == MAX_ID


async def test_ids_are_remembered_within_a_bound() -> None:
    ours = commands()
    running = RemoteCommand("robot/arm")
    ours.expect(ours.id_for("running"), running)
    for number in range(MAX_USED):
        ours.id_for(f"c{number}")
    assert ours.id_for("c0") != "c0"
    ours.id_for("one more")
    assert ours.id_for("c0") == "c0"
    assert ours.id_for("running") != "running"
    ours.forget_command(running)
    assert ours.id_for("running") == "running"
    wide = MAX_USED_TEXT // MAX_ID
    for number in range(wide + 1):
        ours.id_for(f"{number:0{MAX_ID}}")
    first = f"{0:0{MAX_ID}}"
    assert ours.id_for(first) == first
