"""One budget for what waits on all connections: whose connection is cut when it is used up."""

from contextlib import ExitStack
from functools import partial

import pytest

from openrois.jsonrpc.outbox import Outbox, OutboxOverflow
from openrois.jsonrpc.unread import UnreadAccount, UnreadBudget


class Connections:
    """Accounts by name; of which the first letter is the subject."""

    def __init__(self, budget: UnreadBudget, *names: str) -> None:
        self.cut: list[str] = []
        self._stack = ExitStack()
        self.accounts: dict[str, UnreadAccount] = {}
        for name in names:
            account = self._stack.enter_context(budget.account(name[0], partial(self.cut.append, name)))
            self.accounts[name] = account

    def add(self, name: str, text: int) -> None:
        self.accounts[name].add(text)

    def close(self) -> None:
        self._stack.close()


def test_within_the_budget_one_may_have_nearly_all() -> None:
    budget = UnreadBudget(100)
    connections = Connections(budget, "a", "b")
    connections.add("a", 99)
    connections.add("b", 1)
    assert (connections.cut, budget.total, budget.cuts) == ([], 100, 0)
    connections.close()
    assert budget.total == 0


def test_the_fullest_connection_of_the_subject_that_has_most_is_cut() -> None:
    budget = UnreadBudget(100)
    connections = Connections(budget, "a1", "a2", "a3", "b1")
    # The connection of b has more than each of a's, and all of a's more than its share.
    for name, text in (("a1", 20), ("a2", 22), ("a3", 18), ("b1", 35)):
        connections.add(name, text)
    connections.add("b1", 6)
    assert (connections.cut, budget.total, budget.cuts) == (["a2"], 79, 1)
    # What comes for one that was cut counts no more.
    connections.add("a2", 1000)
    connections.accounts["a2"].remove(5)
    assert (connections.cut, budget.total) == (["a2"], 79)
    connections.add("b1", 25)
    assert (connections.cut, budget.total) == (["a2", "b1"], 38)
    connections.close()
    assert budget.total == 0


def test_as_many_are_cut_as_are_needed() -> None:
    budget = UnreadBudget(100)
    connections = Connections(budget, "a1", "a2", "b1")
    connections.add("a1", 50)
    connections.add("a2", 45)
    connections.add("b1", 100)
    assert (connections.cut, budget.total) == (["b1"], 95)
    connections.close()


async def test_an_outbox_counts_what_waits_and_what_is_being_sent() -> None:
    budget, outbox = UnreadBudget(1000), Outbox(event_limit=2)
    with budget.account("a", outbox.close) as outbox.account:
        for text, droppable in (("abc", False), ("12345", True), ("12345", True), ("123456", True)):
            outbox.put(text, droppable=droppable)
        assert budget.total == 3 + 5 + 6
        assert await outbox.get() == "abc"
        assert budget.total == 14
        assert await outbox.get_some(100) == ["12345", "123456"]
        assert budget.total == 11
        outbox.put("last")
        assert await outbox.get() == "last"
        assert budget.total == 4
    assert budget.total == 0


async def test_an_outbox_whose_own_message_uses_it_up_takes_nothing_more() -> None:
    budget, outbox = UnreadBudget(10), Outbox()
    with budget.account("a", outbox.close) as outbox.account:
        outbox.put("12345")
        with pytest.raises(OutboxOverflow, match="too much waits unread on all connections"):
            outbox.put("123456")
        assert (len(outbox), budget.total) == (0, 0)
        with pytest.raises(OutboxOverflow):
            outbox.put("1")
