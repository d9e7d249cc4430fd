from collections.abc import Callable

from openrois.aio.listeners import Listeners


def test_listeners_are_called_until_they_are_removed() -> None:
    heard: list[tuple[str, int, str]] = []
    listeners: Listeners[int, str] = Listeners()
    leave = listeners.add(lambda number, text: heard.append(("one", number, text)))
    listeners.add(lambda number, text: heard.append(("other", number, text)))
    listeners.notify_all(1, "a")
    leave()
    leave()
    listeners.notify_all(2, "b")
    assert heard == [("one", 1, "a"), ("other", 1, "a"), ("other", 2, "b")]


def test_listeners_may_come_and_go_during_a_call() -> None:
    heard: list[str] = []
    listeners: Listeners[()] = Listeners()
    leave: Callable[[], None]

    def once() -> None:
        heard.append("once")
        leave()
        listeners.add(lambda: heard.append("late"))

    leave = listeners.add(once)
    listeners.add(lambda: heard.append("always"))
    listeners.notify_all()
    assert heard == ["once", "always"]
    listeners.notify_all()
    assert heard == ["once", "always", "always", "late"]
