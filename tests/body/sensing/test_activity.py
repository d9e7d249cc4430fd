"""When a sense works."""

from collections.abc import Callable

import pytest
from openrois_body.sensing.activity import Activity


def subscribed(number: int, event_type: str = "seen") -> Callable[[Activity], None]:
    return lambda activity: activity.subscribers_changed(event_type, number)


START, STOP, SUSPEND, RESUME = Activity.start, Activity.stop, Activity.suspend, Activity.resume


@pytest.mark.parametrize(
    ("story", "works"),
    [
        ([], [False]),
        ([subscribed(1), subscribed(2), subscribed(1), subscribed(0)], [True, True, True, False]),
        ([subscribed(1), subscribed(1, "heard"), subscribed(0)], [True, True, True]),
        ([START, subscribed(1), subscribed(0), STOP], [True, True, True, False]),
        ([subscribed(1), STOP, START], [True, False, True]),
        ([subscribed(1), STOP, subscribed(0), subscribed(1)], [True, False, False, True]),
        ([subscribed(1), STOP, subscribed(2)], [True, False, True]),
        ([subscribed(1), SUSPEND, subscribed(2), RESUME], [True, False, False, True]),
        ([START, SUSPEND, START], [True, False, True]),
        ([START, SUSPEND, STOP, START], [True, False, False, True]),
        ([subscribed(1), SUSPEND, subscribed(0), subscribed(1)], [True, False, False, True]),
        ([START, SUSPEND, subscribed(1), subscribed(0)], [True, False, False, False]),
        ([SUSPEND, subscribed(1)], [False, True]),
        ([RESUME, STOP, subscribed(1)], [False, False, True]),
    ],
)
def test_when_it_works(story: list[Callable[[Activity], None]], works: list[bool]) -> None:
    activity = Activity()
    told: list[bool] = []
    activity.changed.add(told.append)
    was = []
    for happens in story:
        happens(activity)
        was.append(activity.works)
    assert (was or [activity.works]) == works
    assert told == [now for before, now in zip([False, *was], was, strict=False) if now != before]


def test_begin_is_called_on_activation_and_its_end_on_deactivation() -> None:
    activity, told = Activity(), list[str]()

    def begin() -> Callable[[], None]:
        told.append("begun")
        return lambda: told.append("ended")

    activity.while_working(begin)
    for happens in (START, START, STOP, STOP, subscribed(1), SUSPEND):
        happens(activity)
    assert told == ["begun", "ended"] * 2
