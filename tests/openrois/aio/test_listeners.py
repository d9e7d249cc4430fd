from collections.abc import Callable

from openrois.aio.listeners import Listeners


def test_everybody_is_told_until_they_leave() -> None:
    heard: list[tuple[str, int, str]] = []
    listeners: Listeners[int, str] = Listeners()
    leave = listeners.add(lambda number, text: heard.append(("one", number, text)))
    listeners.add(lambda number, text: heard.append(("other", number, text)))
    listeners.tell(1, "a")
    leave()
    leave()
    listeners.tell(2, "b")
    assert heard == [("one", 1, "a"), ("other", 1, "a"), ("other", 2, "b")]


def test_who_leaves_or_comes_while_they_are_told_does_not_disturb() -> None:
    heard: list[str] = []
    listeners: Listeners[()] = Listeners()
    leave: Callable[[], None]

    def once() -> None:
        heard.append("once")
        leave()
        listeners.add(lambda: heard.append("late"))

    leave = listeners.add(once)
    listeners.add(lambda: heard.append("always"))
    listeners.tell()
    assert heard == ["once", "always"]
    listeners.tell()
    assert heard == ["once", "always", "always", "late"]
