"""The answers of the suite's own adapter. Pure: a request goes in, the answer and its notifications come out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from openrois.types.profiles import HRIComponentProfile, ParameterProfile
from openrois_conformance.probe_profiles import FATES, profile_result, sample

__all__ = ["EXPIRE", "SILENCE", "Answer", "Notices", "ProbeEngine"]

EXPIRE: Final = "2099-01-01T00:00:00+00:00"
_METHOD_NOT_FOUND: Final = -32601
_INTERNAL_ERROR: Final = -32603

Notices = tuple[tuple[str, dict[str, Any]], ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request: a result, or an error, or with neither none at all; and the notifications after it."""

    result: Mapping[str, Any] | None = None
    error: int | None = None
    then: Notices = ()


SILENCE: Final = Answer()
_REFUSED: Final = Answer({"return_code": "OUT_OF_RESOURCES"})
_CRASHED: Final = Answer(error=_INTERNAL_ERROR)

ExtensionAnswers = Callable[[str, dict[str, Any]], Answer | None]


def _values_of(values: Mapping[str, str], profiles: tuple[ParameterProfile, ...]) -> list[dict[str, str]]:
    """Return values as Results, Parameters or Arguments stand on the wire, with the types of their profiles."""
    codes = {profile.name: profile.data_type_ref.code for profile in profiles}
    return [{"name": name, "data_type_ref": codes[name], "value": value} for name, value in values.items()]


def _samples(profiles: tuple[ParameterProfile, ...]) -> list[dict[str, str]]:
    return _values_of({profile.name: sample(profile.data_type_ref.code) for profile in profiles}, profiles)


def _completed(command_id: str, status: str) -> tuple[str, dict[str, Any]]:
    return "rois.command.completed", {"command_id": command_id, "status": status}


@dataclass
class ProbeEngine:
    """The engine behind the suite's adapter.

    Attributes:
        engine_id: leads its component_refs.
        profiles: what it offers, by component_ref.
        answers: what a method is answered instead of the usual.
        extension: answers the methods of the extensions, where the adapter speaks them.
        subscriptions: by id, the component and event that each is to.
        violations: what the gateway asked that it may not ask.
    """

    engine_id: str
    profiles: dict[str, HRIComponentProfile]
    answers: dict[str, Answer] = field(default_factory=dict)
    extension: ExtensionAnswers | None = None
    subscriptions: dict[str, tuple[str, str]] = field(default_factory=dict)
    violations: list[str] = field(default_factory=list)
    _stored: dict[str, dict[str, str]] = field(default_factory=dict)
    _results: dict[str, list[dict[str, str]]] = field(default_factory=dict)
    _details: dict[str, list[dict[str, str]]] = field(default_factory=dict)
    _faults: dict[str, list[dict[str, str]]] = field(default_factory=dict)
    _hanging: dict[str, list[str]] = field(default_factory=dict)
    _minted: int = 0

    def __post_init__(self) -> None:
        self._methods: dict[str, Callable[[dict[str, Any]], Answer]] = {
            "rois.system.get_profile": self._get_profile,
            "rois.system.get_error_detail": self._get_error_detail,
            "rois.command.execute": self._execute,
            "rois.command.set_parameter": self._set_parameter,
            "rois.command.get_parameter": self._get_parameter,
            "rois.command.get_command_result": self._get_command_result,
            "rois.query.query": self._query,
            "rois.event.subscribe": self._subscribe,
            "rois.event.unsubscribe": self._unsubscribe,
            "rois.event.get_event_detail": self._get_event_detail,
        }
        self.reset()

    def reset(self) -> None:
        """Drop the records of earlier checks."""
        self.answers.clear()
        self.violations.clear()
        self._stored = {
            ref: {parameter.name: parameter.default_value for parameter in profile.parameter_profiles}
            for ref, profile in self.profiles.items()
        }

    def mint(self, kind: str) -> str:
        """Return a new id of the engine."""
        self._minted += 1
        return f"{self.engine_id}/{kind}-{self._minted}"

    def answer_request(self, method: str, params: dict[str, Any]) -> Answer:
        """Return the answer to a request."""
        if method in self.answers:
            return self.answers[method]
        if method in self._methods:
            return self._methods[method](params)
        found = self.extension(method, params) if self.extension is not None else None
        return found or Answer(error=_METHOD_NOT_FOUND)

    def event(self, component_ref: str, event_type: str) -> tuple[str, Notices]:
        """Return the id of a new event, and the notifications of its subscribers."""
        event_id = self.mint("evt")
        profile = next(p for p in self.profiles[component_ref].event_profiles if p.name == event_type)
        self._details[event_id] = _samples(profile.results)
        wanted = (component_ref, event_type)
        listening = [subscribe_id for subscribe_id, to in self.subscriptions.items() if to == wanted]
        return event_id, tuple(self.notice(subscribe_id, event_type, event_id) for subscribe_id in listening)

    def notice(self, subscribe_id: str, event_type: str, event_id: str) -> tuple[str, dict[str, Any]]:
        """Return one notify_event."""
        return "rois.event.notify_event", {
            "event_id": event_id,
            "event_type": event_type,
            "subscribe_id": subscribe_id,
            "expire": EXPIRE,
            "results": self._details.get(event_id, []),
        }

    def fault(self, component_ref: str, error_type: str) -> tuple[str, dict[str, Any]]:
        """Return the notification of a new fault of a component; without a component nothing more is known of it."""
        error_id = self.mint("err")
        if component_ref:
            values = {"component_ref": component_ref, "error_type": error_type, "description": "for the suite"}
            self._faults[error_id] = [
                {"name": name, "data_type_ref": "string", "value": value} for name, value in values.items()
            ]
        return "rois.system.notify_error", {"error_id": error_id, "error_type": error_type}

    def finish(self, component_ref: str, status: str) -> Notices:
        """End the commands of a component that hang; return their notifications."""
        return tuple(_completed(command_id, status) for command_id in self._hanging.pop(component_ref, []))

    def hanging(self) -> dict[str, list[str]]:
        """Return the ids of the commands that hang, by component_ref."""
        return {ref: list(ids) for ref, ids in self._hanging.items()}

    def _get_profile(self, _params: dict[str, Any]) -> Answer:
        return Answer(profile_result(self.engine_id, self.profiles))

    def _get_error_detail(self, params: dict[str, Any]) -> Answer:
        if params["error_id"] not in self._faults:
            return Answer({"return_code": "BAD_PARAMETER", "results": []})
        return Answer({"return_code": "OK", "results": self._faults[params["error_id"]]})

    def _execute(self, params: dict[str, Any]) -> Answer:
        unit = params["command_unit_list"][0]
        command, command_id = unit["command_type"], unit["command_id"]
        special = {"refuse": _REFUSED, "crash": _CRASHED, "ignore": SILENCE}.get(command)
        if special is not None:
            return special
        self._results[command_id] = self._results_of(unit)
        if command == "hang":
            self._hanging.setdefault(unit["component_ref"], []).append(command_id)
            return Answer({"return_code": "OK"})
        return Answer({"return_code": "OK"}, then=(_completed(command_id, FATES.get(command, "OK")),))

    def _results_of(self, unit: dict[str, Any]) -> list[dict[str, str]]:
        if unit["command_type"] == "echo":
            return unit.get("arguments") or []
        profile = self.profiles[unit["component_ref"]].command(unit["command_type"])
        return _samples(profile.results) if profile is not None else []

    def _set_parameter(self, params: dict[str, Any]) -> Answer:
        command_id = self.mint("param")
        self._results[command_id] = []
        values = {parameter["name"]: parameter["value"] for parameter in params["parameters"]}
        self._stored[params["component_ref"]].update(values)
        return Answer({"return_code": "OK", "command_id": command_id}, then=(_completed(command_id, "OK"),))

    def _get_parameter(self, params: dict[str, Any]) -> Answer:
        ref = params["component_ref"]
        values = {name: value for name, value in self._stored[ref].items() if value}
        return Answer({"return_code": "OK", "parameters": _values_of(values, self.profiles[ref].parameter_profiles)})

    def _get_command_result(self, params: dict[str, Any]) -> Answer:
        return Answer({"return_code": "OK", "results": self._results.get(params["command_id"], [])})

    def _query(self, params: dict[str, Any]) -> Answer:
        query = params["query_type"]
        if query.startswith("hang"):
            return SILENCE
        if query.startswith("crash"):
            return _CRASHED
        ref = self._one(params["condition"])
        profile = next(p for p in self.profiles[ref].query_profiles if p.name == query)
        return Answer({"return_code": "OK", "results": _samples(profile.results)})

    def _subscribe(self, params: dict[str, Any]) -> Answer:
        subscribe_id = self.mint("sub")
        self.subscriptions[subscribe_id] = (self._one(params["condition"]), params["event_type"])
        return Answer({"return_code": "OK", "subscribe_id": subscribe_id})

    def _unsubscribe(self, params: dict[str, Any]) -> Answer:
        self.subscriptions.pop(params["subscribe_id"], None)
        return Answer({"return_code": "OK"})

    def _get_event_detail(self, params: dict[str, Any]) -> Answer:
        return Answer({"return_code": "OK", "results": self._details.get(params["event_id"], [])})

    def _one(self, condition: str) -> str:
        """Return the component that a condition of the gateway names."""
        for ref in self.profiles:
            quoted = ref.replace("'", "''")
            if condition == f"component_ref = '{quoted}'":
                return ref
        self.violations.append(f"the condition {condition!r} names no component of the adapter")
        return next(iter(self.profiles))
