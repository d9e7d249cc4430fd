"""The gate before every method: what has no rule is refused, and whatever could name a component is looked up."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, get_args

import pytest
from openrois_signaling.messages import Answer, Candidate, Restart
from openrois_signaling.methods import signaling_methods
from openrois_signaling.relay import Relay
from pydantic import BaseModel

import openrois
from openrois.auth.principal import ALLOWED, LOCAL, Principal, Role
from openrois.gateway import applications
from openrois.interfaces.enforcement import enforced
from openrois.jsonrpc.session import Handler, Reply
from openrois.leases import tokens
from openrois.session.session import ApplicationSession
from openrois.types.messages import ReturnResult, SearchResult
from openrois.types.methods import METHODS
from openrois.types.references import new_id
from tests.openrois.interfaces.test_matrix import RULES
from tests.support.authorization import Place, place, principal

SIGNALING: Final = set(signaling_methods(Relay(None, lambda: 0.0), "anna", None))  # type: ignore[arg-type]

# Every field of every method's params that is a text: what it names, and so which test proves that it is looked up.
# `component`: a reference; `engine`: the id of one; `condition`: comparisons with references; `own`: an id of this
# session alone; `name`: of a message or value, judged by the profile of a component that was looked up, or of a STOP of
# an engine that was; `free`: the application's own text.
FIELDS: Final = {
    "component_ref": "component",
    "condition": "condition",
    "stream_id": "own",
    "peer_id": "own",
    "command_id": "own",
    "subscribe_id": "own",
    "event_id": "own",
    "error_id": "own",
    "request_id": "own",
    "command_ids": "own",
    "engine_id": "engine",
    "engine_ids": "engine",
    "component_refs": "component",
    "component_types": "free",
    "after": "free",
    "command_type": "name",
    "query_type": "name",
    "event_type": "name",
    "name": "name",
    "stop_id": "name",
    "data_type_ref": "name",
    "value": "free",
    "version": "free",
    "token": "free",
    "extensions": "free",
    "sdp": "free",
    "candidate": "free",
    "sdp_mid": "free",
}


def texts_of(model: type[BaseModel]) -> Iterator[str]:
    """Return the names of a model's fields that hold texts, and of those of all models in it."""
    for name, field in model.model_fields.items():
        kinds = list(kinds_of(field.annotation))
        if str in kinds:
            yield name
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                yield from texts_of(kind)


def kinds_of(annotation: Any) -> Iterator[Any]:
    """Return every type that an annotation is made of."""
    inner = get_args(annotation)
    if not inner:
        yield annotation
    for each in inner:
        yield from kinds_of(each)


PARAMS: Final[dict[str, type[BaseModel]]] = {
    **{method.params.__name__: method.params for method in METHODS},
    **{model.__name__: model for model in (Answer, Candidate, Restart)},
}


@pytest.mark.parametrize("model", PARAMS.values(), ids=PARAMS)
def test_every_text_of_every_method_is_known(model: type[BaseModel]) -> None:
    unknown = set(texts_of(model)) - FIELDS.keys()
    assert not unknown, f"say in FIELDS what {unknown} names, and try it in test_hidden and test_ownership"


def test_the_walk_finds_what_is_nested() -> None:
    execute = next(method.params for method in METHODS if method.name == "rois.command.execute")
    assert {"component_ref", "command_type", "command_id", "value"} <= set(texts_of(execute))


@pytest.fixture
async def served(monkeypatch: pytest.MonkeyPatch) -> dict[str, Handler]:
    """Every method that a gateway serves to an application."""
    tables: list[dict[str, Handler]] = []

    def noting(app: ApplicationSession, methods: Mapping[str, Handler]) -> Mapping[str, Handler]:
        tables.append(dict(methods))
        return enforced(app, methods)

    monkeypatch.setattr(applications, "enforced", noting)
    async with place("fleet") as where, where.application(LOCAL):
        pass
    (table,) = tables
    return table


async def test_every_method_that_is_served_has_a_rule(served: dict[str, Handler]) -> None:
    assert served.keys() <= ALLOWED.keys(), "a method without a rule is always refused"
    assert ALLOWED.keys() <= served.keys() | {"openrois.auth.refresh"}, "a rule without a method"
    assert served.keys() <= RULES.keys(), "say in the table of test_matrix what every role gets"
    # A gateway without authentication has no tokens to take.
    assert {method.name for method in METHODS} | SIGNALING <= served.keys() | {"openrois.auth.refresh"}


async def test_every_method_passes_the_gate(served: dict[str, Handler]) -> None:
    async with place("fleet") as where, where.application(principal(None, "*")) as wire:
        for method in served:
            assert await wire.code(method, {}) == "UNSUPPORTED"


async def empty_search(_params: dict[str, Any]) -> Any:
    return SearchResult(component_ref_list=("fleet/secret",))


def session(where: Place, who: Principal) -> ApplicationSession:
    return ApplicationSession(where.host, lambda *_told, **_how: None, principal=who)


async def test_a_method_without_a_rule_is_refused_to_every_role() -> None:
    async with place("fleet") as where:
        for who in (LOCAL, *(principal(role, "*") for role in Role)):
            methods = enforced(session(where, who), {"openrois.later": empty_search})
            reply = await methods["openrois.later"]({})
            assert isinstance(reply, Reply)
            assert reply.result == ReturnResult.model_validate({"return_code": "UNSUPPORTED"})
            assert reply.reason == "openrois.later is not for the roles of this application"


async def test_a_refusal_has_the_shape_of_the_methods_result_and_reads_no_params() -> None:
    async with place("fleet") as where:
        app = session(where, principal("adapter", "*"))
        methods = enforced(app, {"rois.command.search": empty_search})
        reply = await methods["rois.command.search"]({"condition": object()})
        assert reply.result == SearchResult.model_validate({"return_code": "UNSUPPORTED"})


async def test_what_is_allowed_is_asked_at_every_call() -> None:
    async with place("fleet") as where:
        app = session(where, principal("adapter", "*"))
        methods = enforced(app, {"rois.command.search": empty_search})
        app.principal = principal("viewer", "*")
        assert (await methods["rois.command.search"]({})).component_ref_list == ("fleet/secret",)
        app.principal = principal(None)
        assert isinstance(await methods["rois.command.search"]({}), Reply)


def test_everything_that_is_minted_has_128_random_bits() -> None:
    """Ids of the control plane: a session knows those of another one only if it was given them."""
    minted = {}
    for path in sorted(Path(openrois.__file__).parent.rglob("*.py")):
        for bits in re.findall(r"secrets\.token_\w+\(([^)]*)\)", path.read_text()):
            minted[f"{path.parent.name}/{path.name}", bits] = int(bits) if bits.isdigit() else vars(tokens)[bits]
    # The name of an adapter's connection in log lines opens nothing.
    assert minted.pop(("gateway/adapters.py", "4")) == 4
    # Nor do the names of a gateway's process and of its link, which stay between gateways, nor that of a doctor's look.
    assert [minted.pop((f"cluster/{name}.py", "8")) for name in ("examination", "exchange", "pulse")] == [8, 8, 8]
    assert len(minted) >= 8
    assert min(minted.values()) >= 16
    assert len(new_id("robot").removeprefix("robot/")) == 32


def test_operations_reach_the_engine_through_what_is_shown_of_it() -> None:
    """The engine itself is for what ends a stream that is not shown any more, and for STOP, which spares nothing."""
    reached = {
        path.name: path.read_text().count("host.engine")
        for path in sorted(Path(openrois.__file__).with_name("interfaces").glob("*.py"))
        if "host.engine" in path.read_text()
    }
    assert reached == {"stop.py": 2, "stream.py": 1}
