"""A reply leaves before the notifications that its call causes, and nothing waits longer than that."""

from openrois.jsonrpc.reply_order import MAX_HELD, ReplyFirst


class Told(list[str]):
    """Notifications in the order in which they left."""


def ordered() -> tuple[ReplyFirst, Told]:
    told = Told()
    return ReplyFirst(), told


def test_with_nothing_asked_notifications_leave_at_once() -> None:
    order, told = ordered()
    order.notify_after_replies("a", lambda: told.append("1"))
    assert told == ["1"]


def test_what_comes_during_a_call_leaves_after_its_reply_in_order() -> None:
    order, told = ordered()
    replied = order.asked("a")
    for number in "123":
        order.notify_after_replies("a", lambda number=number: told.append(number))  # type: ignore[misc]
    assert told == []
    replied()
    replied()
    assert told == ["1", "2", "3"]


def test_one_engine_does_not_wait_for_another() -> None:
    order, told = ordered()
    order.asked("a")
    order.notify_after_replies("b", lambda: told.append("b"))
    assert told == ["b"]


def test_a_notification_waits_for_the_calls_before_it_and_not_for_later_ones() -> None:
    order, told = ordered()
    first, second = order.asked("a"), order.asked("a")
    order.notify_after_replies("a", lambda: told.append("1"))
    third = order.asked("a")
    order.notify_after_replies("a", lambda: told.append("2"))
    second()
    assert told == []
    first()
    assert told == ["1"]
    third()
    assert told == ["1", "2"]


def test_order_is_kept_when_a_later_call_ends_first() -> None:
    order, told = ordered()
    first = order.asked("a")
    order.notify_after_replies("a", lambda: told.append("1"))
    second = order.asked("a")
    order.notify_after_replies("a", lambda: told.append("2"))
    second()
    assert told == []
    first()
    assert told == ["1", "2"]


def test_what_is_held_is_bounded_and_nothing_is_lost() -> None:
    order, told = ordered()
    replied = order.asked("a")
    for number in range(MAX_HELD + 3):
        order.notify_after_replies("a", lambda number=number: told.append(str(number)))  # type: ignore[misc]
    assert told == ["0", "1", "2"]
    replied()
    assert told == [str(number) for number in range(MAX_HELD + 3)]


def test_clear_drops_what_is_held() -> None:
    order, told = ordered()
    replied = order.asked("a")
    order.notify_after_replies("a", lambda: told.append("1"))
    order.clear()
    replied()
    order.notify_after_replies("a", lambda: told.append("2"))
    assert told == ["2"]
