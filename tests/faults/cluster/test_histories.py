"""The judgement of histories, with histories that are bad."""

import pytest

from tests.support.histories import Accepted, Completed, Connected, Entry, Held, History, Lost, Ran, judge

ARM = "robot/arm"
GOOD: list[Entry] = [
    Held(1, ARM, 10, "one", True),
    Accepted(2, "app", "a"),
    Ran(2.1, ARM, 10, "a"),
    Completed(2.2, "app", "a", "OK"),
    Held(3, ARM, 10, "one", False),
    Held(4, ARM, 2010, "two", True),
    Accepted(5, "app", "b"),
    Ran(5.1, ARM, 2010, "b"),
    Completed(5.2, "app", "b", "ABORT"),
]


def found(*entries: Entry) -> list[str]:
    return judge(History(list(entries)))


def test_a_good_history() -> None:
    assert found(*GOOD) == []
    assert found(*reversed(GOOD)) == []


def test_a_smaller_epoch_of_another_component_is_none_of_its_business() -> None:
    assert found(*GOOD, Held(6, "other/arm", 7, "three", True), Ran(7, "other/arm", 7, "c")) == []


def test_the_end_of_a_former_holder_may_come_late() -> None:
    assert found(*GOOD, Held(6, ARM, 10, "one", False)) == []


@pytest.mark.parametrize(
    ("entry", "wrong"),
    [
        (Held(6, ARM, 11, "three", True), "6.000: three holds robot/arm by epoch 11, behind 2010 (F23)"),
        (Ran(6, ARM, 10, "c"), "6.000: c runs at robot/arm by epoch 10, behind 2010 (F23)"),
        (Ran(6, ARM, 0, "c"), "6.000: c runs at robot/arm for no holder (F23)"),
        (Held(6, ARM, 2010, "three", True), "6.000: epoch 2010 of robot/arm is that of two, and then of three (F24)"),
        (Held(6, ARM, 10, "three", False), "6.000: epoch 10 of robot/arm is that of one, and then of three (F24)"),
        (Completed(6, "app", "a", "ERROR"), "a ended 2 times: OK, ERROR (I2)"),
        (Completed(6, "app", "c", "ERROR"), "c ended ERROR and was not accepted (I2)"),
        (Accepted(6, "app", "c"), "6.000: c of app was accepted and has no end (I2)"),
        (Ran(6, ARM, 2010, "b"), "6.000: b runs again (I11)"),
    ],
)
def test_a_bad_history(entry: Entry, wrong: str) -> None:
    assert found(*GOOD, entry) == [wrong]


def test_a_holder_that_is_still_there_when_a_former_one_comes_back() -> None:
    assert found(*GOOD[:1], Held(2, ARM, 20, "two", True), Held(3, ARM, 10, "one", True)) == [
        "3.000: one holds robot/arm by epoch 10, behind 20 (F23)"
    ]


def test_an_application_goes_on_by_its_epoch_over_another_connection() -> None:
    went_on = Held(6, ARM, 2010, "three", True)
    assert found(Connected(0, "app", "two"), Connected(5, "app", "three"), *GOOD, went_on) == []
    assert found(Connected(0, "app", "two"), Connected(5, "other", "three"), *GOOD, went_on) == [
        "6.000: epoch 2010 of robot/arm is that of app, and then of other (F24)"
    ]


def test_a_command_may_begin_while_its_end_is_told_and_not_much_later() -> None:
    told: list[Entry] = [*GOOD, Accepted(6, "app", "c"), Completed(7, "app", "c", "ERROR")]
    assert found(*told, Ran(8, ARM, 2010, "c")) == []
    assert judge(History([*told, Ran(37, ARM, 2010, "c")]), late=40) == []
    assert found(*told, Ran(37, ARM, 2010, "c")) == ["37.000: c runs 30.0 s after it ended ERROR (I11)"]


def test_an_end_that_was_lost_with_the_journal() -> None:
    endless, no_end = [*GOOD, Accepted(6, "app", "c")], ["6.000: c of app was accepted and has no end (I2)"]
    lost = [*endless, Lost(7, "app", "c")]
    assert judge(History(lost), may_forget=True) == []
    assert judge(History(lost)) == no_end
    assert judge(History(endless), may_forget=True) == no_end
    assert judge(History([*lost, Completed(8, "app", "c", "ERROR")]), may_forget=True) == [
        "c ended 2 times: lost, ERROR (I2)"
    ]


def test_what_ended_ok_has_run() -> None:
    assert found(*GOOD, Accepted(6, "app", "c"), Completed(7, "app", "c", "OK")) == [
        "7.000: c ended OK and never ran (I11)"
    ]
