"""The table of methods and notifications, against the operations of the standard written down by hand."""

from openrois.types.methods import METHODS, NOTIFICATIONS

Parameters = tuple[str, ...]

OPERATIONS: dict[str, dict[str, tuple[Parameters, Parameters]]] = {
    "system": {
        "connect": ((), ()),
        "disconnect": ((), ()),
        "get_profile": (("condition",), ("profile", "component_profiles")),
        "get_error_detail": (("error_id", "condition"), ("results",)),
    },
    "command": {
        "search": (("condition",), ("component_ref_list",)),
        "bind": (("component_ref",), ()),
        "bind_any": (("condition",), ("component_ref",)),
        "release": (("component_ref",), ()),
        "get_parameter": (("component_ref",), ("parameters",)),
        "set_parameter": (("component_ref", "parameters"), ("command_id",)),
        "execute": (("command_unit_list",), ()),
        "get_command_result": (("command_id", "condition"), ("results",)),
    },
    "query": {"query": (("query_type", "condition"), ("results",))},
    "event": {
        "subscribe": (("event_type", "condition"), ("subscribe_id",)),
        "unsubscribe": (("subscribe_id",), ()),
        "get_event_detail": (("event_id", "condition"), ("results",)),
    },
}
"""In and out parameters by interface and operation; `component_profiles` is an extension of the wire."""

CALLBACKS: dict[str, Parameters] = {
    "rois.system.notify_error": ("error_id", "error_type"),
    "rois.system.profile_changed": (),
    "rois.command.completed": ("command_id", "status"),
    "rois.event.notify_event": ("event_id", "event_type", "subscribe_id", "expire", "results"),
}


def test_the_sixteen_operations_of_the_base() -> None:
    found = {
        each.name: (tuple(each.params.model_fields), tuple(each.result.model_fields))
        for each in METHODS
        if not each.extension
    }
    assert found == {
        f"rois.{interface}.{operation}": (given, ("return_code", *out))
        for interface, operations in OPERATIONS.items()
        for operation, (given, out) in operations.items()
    }
    assert len(found) == 16


def test_the_four_notifications_of_the_base() -> None:
    assert {each.name: tuple(each.params.model_fields) for each in NOTIFICATIONS if not each.extension} == CALLBACKS


def test_a_name_stands_once_and_is_described() -> None:
    names = [*(each.name for each in METHODS), *(each.name for each in NOTIFICATIONS)]
    assert len(names) == len(set(names))
    assert all(
        summary.endswith(".") for summary in (*(m.summary for m in METHODS), *(n.summary for n in NOTIFICATIONS))
    )
