"""Which requests run, wait or are refused."""

from collections.abc import Callable

import pytest

from openrois.aio.rate import RateLimit
from openrois.jsonrpc import request_queue as module
from openrois.jsonrpc.protocol import Request
from openrois.jsonrpc.request_queue import QueueRules, RequestQueue
from tests.support.clock import Clock


class Door:
    """An intake, and what it decided."""

    def __init__(self, rate: RateLimit | None = None) -> None:
        self.started: list[str] = []
        self.over: dict[str, Callable[[], None]] = {}
        self.refused: dict[str, str] = {}
        self.read: list[str] = []
        rules = QueueRules(
            lambda request: request.method == "stop",
            lambda urgent: {urgent.params},
            lambda waiting: self._read(waiting),
            rate=rate,
        )
        self.queue = RequestQueue(self._start, self._refuse, rules)

    def _read(self, waiting: Request) -> set[str]:
        self.read.append(str(waiting.id))
        return {waiting.params}

    def _start(self, request: Request, over: Callable[[], None]) -> None:
        self.started.append(str(request.id))
        self.over[str(request.id)] = over

    def _refuse(self, request: Request, reason: str) -> None:
        self.refused[str(request.id)] = reason

    def ask(self, *names: str, method: str = "act", about: str = "lamp", length: int = 10) -> None:
        for name in names:
            self.queue.put_request(Request(name, method, about), length)


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_RUNNING_REQUESTS", 2)
    monkeypatch.setattr(module, "MAX_WAITING_REQUESTS", 3)
    monkeypatch.setattr(module, "MAX_WAITING_TEXT", 100)
    monkeypatch.setattr(module, "MAX_URGENT_REQUESTS", 2)


def test_so_many_run_others_wait_in_line_and_too_many_are_refused() -> None:
    door = Door()
    door.ask("a", "b", "c", "d", "e", "f")
    assert (door.started, len(door.queue), list(door.refused)) == (["a", "b"], 3, ["f"])
    assert door.refused["f"] == "3 requests wait already; retry_after=1"
    for name in ("b", "a", "c"):
        door.over[name]()
    assert door.started == ["a", "b", "c", "d", "e"]
    for name in ("d", "e"):
        door.over[name]()
    door.ask("g", "h", "i")
    assert door.started[5:] == ["g", "h"]
    assert (len(door.queue), door.queue.refused) == (1, 1)


def test_what_waits_when_the_connection_ends_never_starts() -> None:
    door = Door()
    door.ask("a", "b", "c", "d")
    door.queue.close()
    door.over["a"]()
    assert (door.started, len(door.queue)) == (["a", "b"], 0)


def test_those_that_wait_are_bounded_by_their_text_too() -> None:
    door = Door()
    door.ask("a", "b", "c")
    door.ask("d", length=91)
    door.ask("e", length=90)
    assert list(door.refused) == ["d"]
    door.over["a"]()
    door.ask("f", length=10)
    assert list(door.refused) == ["d"]
    assert len(door.queue) == 2


def test_what_is_urgent_passes_all_and_is_the_last_word_on_what_it_is_about() -> None:
    door = Door()
    door.ask("a", "b", "c")
    door.ask("d", about="door", length=90)
    door.ask("s", method="stop", length=1000)
    assert door.started == ["a", "b", "s"]
    assert door.refused == {"c": "it waited when stop came"}
    door.ask("e")
    assert (len(door.queue), door.queue.urgent) == (2, 1)
    door.over["a"]()
    assert door.started[-1] == "d"


def test_what_waits_is_read_once_however_many_urgent_ones_pass() -> None:
    """They count against no limit, and to read 16,384 requests again for each took a second."""
    door = Door()
    door.ask("a", "b", "c", "d", "e")
    for name in "stuvw":
        door.ask(name, method="stop", about="door")
        door.over[name]()
    assert door.read == ["c", "d", "e"]


def test_urgent_ones_do_not_count_until_there_are_too_many_of_them() -> None:
    door = Door()
    door.ask("a")
    door.ask("s", "t", "u", "v", method="stop", about="door")
    assert door.started == ["a", "s", "t", "u"]
    door.over["s"]()
    door.ask("w", method="stop", about="door")
    assert door.started[-1] == "w"
    assert door.refused == {"v": "it waited when stop came"}


def test_too_many_requests_are_refused_with_retry_after() -> None:
    clock = Clock()
    door = Door(RateLimit(2, 4, clock))
    door.ask("a", "b", "c")
    door.ask("s", method="stop", about="door")
    assert door.started == ["a", "b", "s"]
    assert door.refused == {"c": "too many requests a second; retry_after=0.250"}
    door.over["a"]()
    clock.now = 0.25
    door.ask("d", "e")
    assert door.started[-1] == "d"
    assert list(door.refused) == ["c", "e"]


def test_without_rules_nothing_is_urgent() -> None:
    started: list[Request] = []
    queue = RequestQueue(lambda request, _over: started.append(request), lambda _request, _reason: None, QueueRules())
    for number in range(4):
        queue.put_request(Request(number, "stop", {}), 1)
    assert ([request.id for request in started], len(queue), queue.urgent) == ([0, 1], 2, 0)
    assert not QueueRules().meant(started[0])
    assert QueueRules().named(started[0]) is None
    assert QueueRules().refusal("stop") is None
