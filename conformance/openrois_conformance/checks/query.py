"""The Query interface: how a component is chosen, and its answers."""

from typing import Final

from openrois_conformance.checks.command import BIND
from openrois_conformance.checks.system import REFUSED_CONDITIONS
from openrois_conformance.deviation import expect
from openrois_conformance.probe_profiles import PARAMETERS, URN, sample
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

QUERY: Final = "rois.query.query"


@CHECKS("query", Needs.ADAPTER)
async def _query(stage: Stage) -> None:
    """`query` answers the results of the one component that has it: values of every type, as text, unchanged."""
    app = await stage.application()
    answer = await app.granted(QUERY, query_type="view_of_eye")
    wanted = [{"name": name, "data_type_ref": code, "value": sample(code)} for name, code, _ in PARAMETERS]
    expect("the results", answer["results"], wanted)


@CHECKS("query-selection", Needs.ADAPTER)
async def _query_selection(stage: Stage) -> None:
    """`query` needs a condition that exactly one component with that query satisfies; by reference it finds it."""
    app = await stage.application()
    arm, engine_id = stage.ref("arm"), stage.probe.engine.engine_id
    for condition, code in (
        (f"component_ref = '{arm}'", "OK"),
        (f"component_ref LIKE '{engine_id}/a%m' AND component_type = '{URN}'", "OK"),
        (f"component_ref LIKE '{engine_id}/%'", "BAD_PARAMETER"),
        (f"component_ref = '{engine_id}/absent'", "UNSUPPORTED"),
        (f"component_ref = '{stage.ref('person_detecter')}'", "UNSUPPORTED"),
    ):
        expect(
            f"the return_code of query view where {condition}",
            await app.code(QUERY, query_type="view", condition=condition),
            code,
        )
    for condition in REFUSED_CONDITIONS:
        await app.refused(QUERY, "BAD_PARAMETER", query_type="view_of_arm", condition=condition)
    asked = stage.probe.params_of(QUERY)
    expect("how many queries reached the adapter", len(asked), 2)


@CHECKS("query-unknown")
async def _query_unknown(stage: Stage) -> None:
    """A query that no component has is answered UNSUPPORTED."""
    app = await stage.application()
    for query_type in ("conformance unknown", "", "get_parameter"):
        await app.refused(QUERY, "UNSUPPORTED", query_type=query_type, condition="component_ref LIKE '%'")


@CHECKS("query-condition-refused")
async def _query_condition_refused(stage: Stage) -> None:
    """`query` answers BAD_PARAMETER to a condition that cannot be read."""
    app = await stage.application()
    for condition in REFUSED_CONDITIONS:
        await app.refused(QUERY, "BAD_PARAMETER", query_type="component_status", condition=condition)


@CHECKS("query-needs-no-bind", Needs.ADAPTER)
async def _query_needs_no_bind(stage: Stage) -> None:
    """`query` of an actuation that another application has bound is answered."""
    app, other = await stage.application(), await stage.application()
    await other.granted(BIND, component_ref=stage.ref("arm"))
    await app.granted(QUERY, query_type="view_of_arm")


@CHECKS("query-status", Needs.ADAPTER)
async def _query_status(stage: Stage) -> None:
    """`component_status` is answered with the enumerator's name."""
    app = await stage.application()
    condition = f"component_ref = '{stage.ref('eye')}'"
    answer = await app.granted(QUERY, query_type="component_status", condition=condition)
    wanted = {"name": "status", "data_type_ref": "Component_Status", "value": "READY"}
    expect("the results", answer["results"], [wanted])


@CHECKS("query-adapter-fails", Needs.ADAPTER)
async def _query_adapter_fails(stage: Stage) -> None:
    """A query that the adapter answers with a JSON-RPC error is answered ERROR, without any text of the error."""
    app = await stage.application()
    await app.refused(QUERY, "ERROR", query_type="crash_of_eye")
    texts = [frame.text for frame in stage.setting.transcript.frames if frame.who == app.name]
    expect("whether the adapter's words got out", any("the suite's adapter refuses" in text for text in texts), False)


@CHECKS("query-adapter-lost", Needs.ADAPTER)
async def _query_adapter_lost(stage: Stage) -> None:
    """A query that waits for an adapter that is lost is answered ERROR."""
    app = await stage.application()
    second = await stage.attached()
    params = {"query_type": "hang_of_eye", "condition": f"component_ref = '{second.ref('eye')}'"}
    waiting = await app.begin(QUERY, **params)
    await second.until(lambda: bool(second.params_of(QUERY)), "ask its adapter")
    await second.socket.close()
    expect("the result", await app.result(QUERY, waiting), {"return_code": "ERROR", "results": []})
