"""Which application holds a component, by the notifications of its gateway."""

from openrois_body.holder import ComponentHolder

from openrois.contract import Client
from openrois.types.streams import HolderNotification

ANN, BOB = (Client(name, lambda _method, _params: None) for name in ("ann", "bob"))


def told(holds: bool, epoch: int, ref: str = "robot/lamp") -> HolderNotification:
    return HolderNotification(component_ref=ref, holds=holds, epoch=epoch)


def test_it_changes_hands_with_a_later_epoch_and_says_what_the_former_holder_is_told() -> None:
    held = ComponentHolder("robot/lamp")
    assert held.client is None
    assert held.apply(told(True, 1), ANN) == ""
    assert held.apply(told(True, 2), ANN) == ""
    assert held.apply(told(True, 3), BOB) == "another application has bound the component"
    assert held.client is BOB
    assert held.apply(told(False, 3), BOB) == "the component was released"
    assert held.client is None


def test_what_is_late_or_of_another_component_changes_nothing() -> None:
    held = ComponentHolder("robot/lamp")
    held.apply(told(True, 5), BOB)
    for late in (told(True, 4), told(False, 4), told(False, 6, "robot/door"), told(True, 6, "robot/door")):
        assert held.apply(late, ANN) == ""
    assert held.client is BOB
    assert not held.forget_client(ANN)
    assert held.forget_client(BOB)
    assert held.client is None


def test_without_a_component_no_application_holds_it() -> None:
    held = ComponentHolder("")
    assert held.apply(told(True, 1), ANN) == ""
    assert held.client is None
