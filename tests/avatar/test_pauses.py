from openrois_avatar.link.messages import Log, Pause
from openrois_avatar.pauses import Pauses


def test_each_change_is_told_once() -> None:
    pauses, told = Pauses(), list[bool]()
    pauses.changed.add(told.append)
    for event in (Log("x"), Pause(False), Pause(True), Pause(True), Pause(False), Pause(True)):
        pauses.take(event)
    pauses.clear()
    pauses.clear()
    assert told == [True, False, True, False]
    assert not pauses.on
