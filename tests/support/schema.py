"""The wire as a strict application reads it, written by hand: every field and its type, no others."""

from typing import Any

RETURN_CODES = {"OK", "ERROR", "BAD_PARAMETER", "UNSUPPORTED", "OUT_OF_RESOURCES", "TIMEOUT"}
COMPLETED_STATUS = {"OK", "ERROR", "ABORT", "OUT_OF_RESOURCES", "TIMEOUT"}
ERROR_TYPES = {
    "ENGINE_INTERNAL_ERROR",
    "COMPONENT_INTERNAL_ERROR",
    "COMPONENT_NOT_RESPONDING",
    "USER_DEFINED_ERROR",
}
STREAM_STATUS = {f"STREAMING_{name}" for name in ("NOT_CONNECTED", "NOT_RUNNING", "RUNNING", "SUSPENDED", "RESUMED")}
FUNCTIONS = {"actuation", "sensing", "function"}


class Optional:
    """A field that may be null."""

    def __init__(self, schema: Any) -> None:
        self.schema = schema


class Absent:
    """A field that may be absent."""

    def __init__(self, schema: Any) -> None:
        self.schema = schema


class OneOf:
    """A field that is of one of several types."""

    def __init__(self, *types: type) -> None:
        self.types = types


VALUE = {"name": str, "data_type_ref": str, "value": str}
IDENTIFIER = {"code": str, "authority": str, "codebook_ref": str, "version": str}
PARAMETER_PROFILE = {"name": str, "data_type_ref": IDENTIFIER, "default_value": str, "description": str}
MESSAGE_PROFILE = {"name": str, "results": [PARAMETER_PROFILE]}
COMPONENT_PROFILE = {
    "identifier": IDENTIFIER,
    "name": str,
    "function": Optional(FUNCTIONS),
    "part": Optional(str),
    "sub_component_profiles": [str],
    "command_profiles": [{**MESSAGE_PROFILE, "arguments": [PARAMETER_PROFILE], "timeout": Optional(int)}],
    "query_profiles": [MESSAGE_PROFILE],
    "event_profiles": [MESSAGE_PROFILE],
    "parameter_profiles": [PARAMETER_PROFILE],
}
ENGINE_PROFILE: dict[str, Any] = {
    "identifier": IDENTIFIER,
    "component_ids": [str],
    "parameter_profiles": [PARAMETER_PROFILE],
}
ENGINE_PROFILE["sub_profiles"] = [ENGINE_PROFILE]

LEASE = {
    "component_ref": str,
    "state": {"FREE", "MINE", "HELD", "ABSENT"},
    "holder": str,
    "epoch": int,
    "waiting": int,
    "position": int,
    "stopped_by": str,
    "stop_id": str,
    "part": str,
    "lender": str,
    "return_ms": int,
    "return_position": int,
}

ENGINE_ENTRY = {
    "engine_id": str,
    "parent_id": str,
    "version": str,
    "extensions": [str],
    "components": [
        {
            "component_ref": str,
            "component_type": str,
            "function": Optional(FUNCTIONS),
            "profile_version": str,
        }
    ],
}

RESULTS: dict[str, dict[str, Any]] = {
    "rois.system.connect": {},
    "rois.system.disconnect": {},
    "rois.system.get_profile": {
        "profile": Optional(ENGINE_PROFILE),
        "component_profiles": {"*": COMPONENT_PROFILE},
    },
    "rois.system.get_error_detail": {"results": [VALUE]},
    "rois.command.search": {"component_ref_list": [str]},
    "rois.command.bind": {},
    "rois.command.bind_any": {"component_ref": str},
    "rois.command.release": {},
    "rois.command.get_parameter": {"parameters": [VALUE]},
    "rois.command.set_parameter": {"command_id": str},
    "rois.command.execute": {},
    "rois.command.get_command_result": {"results": [VALUE]},
    "rois.query.query": {"results": [VALUE]},
    "rois.event.subscribe": {"subscribe_id": str},
    "rois.event.unsubscribe": {},
    "rois.event.get_event_detail": {"results": [VALUE]},
    "openrois.auth.refresh": {"seconds": int},
    "openrois.hello": {
        "version": str,
        "extensions": [str],
        "engines": [str],
        "client_id": str,
        "instance": str,
        "epoch": int,
        "stopped": [{"engine_id": str, "by": str}],
    },
    "rois.stream.connect_stream": {"stream_id": str},
    "rois.stream.disconnect_stream": {},
    "rois.stream.suspend_stream": {},
    "rois.stream.resume_stream": {},
    "rois.stream.query_stream_status": {"status": STREAM_STATUS},
    "rois.stream.report_playout": {},
    "rois.stream.set_consent": {"visitor_ref": str},
    "openrois.directory.list": {"engines": [ENGINE_ENTRY], "next": str, "count": int},
    "openrois.directory.read": {"engines": [ENGINE_ENTRY], "left": [str]},
    "openrois.directory.profiles": {"profiles": {"*": COMPONENT_PROFILE}, "left": [str]},
    "openrois.lease.query": {"lease": Optional(LEASE)},
    "openrois.lease.request": {"lease": Optional(LEASE), "request_id": str},
    "openrois.lease.leave": {},
    "openrois.lease.grant": {},
    "openrois.lease.decline": {},
    "openrois.lease.borrow": {"lease": Optional(LEASE)},
    "openrois.lease.give_back": {},
    "openrois.lease.take": {"lease": Optional(LEASE)},
    "openrois.lease.token": {"token": str, "grace_ms": int},
    "openrois.lease.resume": {
        "token": str,
        "grace_ms": int,
        "leases": [{"component_ref": str, "epoch": int}],
        "forgotten": [str],
    },
    "openrois.stop_all": {"stopped": [str], "failed": [str]},
    "openrois.lease.release_stop": {},
    "signaling.answer": {},
    "signaling.candidate": {},
    "signaling.restart": {},
    "signaling.ice_servers": {
        "ice_servers": Absent([{"urls": [str], "username": Absent(str), "credential": Absent(str)}]),
        "ttl": Absent(int),
    },
}

NOTIFICATIONS: dict[str, dict[str, Any]] = {
    "rois.command.completed": {"command_id": str, "status": COMPLETED_STATUS},
    "rois.event.notify_event": {
        "event_id": str,
        "event_type": str,
        "subscribe_id": str,
        "expire": str,
        "results": [VALUE],
    },
    "rois.system.notify_error": {"error_id": str, "error_type": ERROR_TYPES},
    "rois.system.profile_changed": {},
    "openrois.auth.expiring": {"seconds": int},
    "openrois.events_dropped": {"count": int},
    "openrois.reason": {"request_id": Absent(OneOf(str, int, float)), "command_id": Absent(str), "reason": str},
    "rois.stream.notify_stream_status": {
        "stream_id": str,
        "component_ref": str,
        "status": STREAM_STATUS,
        "timestamp": str,
    },
    "openrois.directory.changed": {"changed": [str], "gone": [str], "unnamed": int},
    "openrois.lease.changed": {**LEASE, "reason": str},
    "openrois.lease.stopped": {"engine_id": str, "by": str, "reason": str, "stop_id": str},
    "openrois.lease.requested": {"component_ref": str, "request_id": str, "subject": str, "answer_ms": int},
    "openrois.lease.declined": {"component_ref": str, "request_id": str, "reason": str},
    "openrois.lease.withdrawn": {"component_ref": str, "request_id": str},
    "signaling.offer": {
        "peer_id": str,
        "generation": int,
        "sdp": str,
        "streams": [{"mid": str, "stream_id": str, "component_ref": str, "kind": str, "direction": str}],
        "replaces": Absent(str),
    },
    "signaling.candidate": {
        "peer_id": str,
        "generation": int,
        "candidate": Optional(str),
        "sdp_mid": Absent(Optional(str)),
        "sdp_m_line_index": Absent(Optional(int)),
    },
    "signaling.capture_clocks": {
        "peer_id": str,
        "senders": [{"mid": str, "ssrc": int, "clock_rate": int, "rtp_origin": int, "wall": int}],
    },
    "signaling.bye": {"peer_id": str, "reason": str},
}


def check(schema: Any, value: Any, path: str = "") -> None:
    """Assert that `value` is what `schema` says."""
    if isinstance(schema, Optional):
        if value is not None:
            check(schema.schema, value, path)
    elif isinstance(schema, OneOf):
        assert type(value) in schema.types, f"{path}: {value!r}"
    elif isinstance(schema, set):
        assert value in schema, f"{path}: {value!r}"
    elif isinstance(schema, list):
        assert isinstance(value, list), f"{path}: {value!r}"
        for index, item in enumerate(value):
            check(schema[0], item, f"{path}.{index}")
    elif isinstance(schema, dict):
        _check_object(schema, value, path)
    else:
        assert type(value) is schema, f"{path}: {value!r}"


def _check_object(schema: dict[str, Any], value: Any, path: str) -> None:
    assert isinstance(value, dict), f"{path}: {value!r}"
    if "*" in schema:
        schema = dict.fromkeys(value, schema["*"])
    required = {name for name, inner in schema.items() if not isinstance(inner, Absent)}
    assert required <= set(value) <= set(schema), f"{path}: has {sorted(value)}, not {sorted(schema)}"
    for name, item in value.items():
        inner = schema[name]
        check(inner.schema if isinstance(inner, Absent) else inner, item, f"{path}.{name}")


def check_result(method: str, result: Any) -> None:
    """Assert that a result has every field of its method and no other."""
    check({"return_code": RETURN_CODES, **RESULTS[method]}, result, method)


def check_notification(method: str, params: Any) -> None:
    """Assert that a notification is one of the wire's, with every field and no other."""
    check(NOTIFICATIONS[method], params, method)
