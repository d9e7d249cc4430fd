"""The extension `openrois.lease`: holding, requesting, handing over, resuming, and STOP."""

from typing import Any, Final

from openrois_conformance.application import Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe_engine import SILENCE
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()
BOTH: Final = (Needs.ADAPTER, Needs.LEASES)

BIND: Final = "rois.command.bind"
RELEASE: Final = "rois.command.release"
EXECUTE: Final = "rois.command.execute"
LOOK: Final = "openrois.lease.query"
REQUEST: Final = "openrois.lease.request"
LEAVE: Final = "openrois.lease.leave"
GRANT: Final = "openrois.lease.grant"
DECLINE: Final = "openrois.lease.decline"
TAKE: Final = "openrois.lease.take"
TOKEN: Final = "openrois.lease.token"  # noqa: S105
RESUME: Final = "openrois.lease.resume"
STOP_ALL: Final = "openrois.stop_all"

FLOOD: Final = 300
"""Requests that are sent before a STOP: more than a gateway serves at a time."""

RESUMED: Final = 4409
"""Closes a connection that another one goes on for."""

_HOUR: Final = 3_600_000


async def _leasing(stage: Stage) -> Application:
    """Return an application that gets notifications of leases: it has queried that of the suite's arm."""
    app = await stage.application()
    await _lease(app, stage.ref("arm"))
    return app


async def _lease(app: Application, component_ref: str) -> dict[str, Any]:
    """Return a component's lease, and get notifications of it from then on."""
    lease = (await app.granted(LOOK, component_ref=component_ref))["lease"]
    if lease is None:
        raise Deviation(f"how things stand with {component_ref}", "null")
    expect("the component", lease["component_ref"], component_ref)
    return dict(lease)


async def _told(app: Application, component_ref: str, state: str, **more: Any) -> dict[str, Any]:
    """Wait until an application is notified of such a lease; notifications before that do not count."""
    while True:
        told = await app.next("openrois.lease.changed")
        if {**told, **more, "state": state, "component_ref": component_ref} == told:
            return told


def _unit(component_ref: str, command_id: str, command_type: str = "hang", **more: Any) -> dict[str, Any]:
    return {"component_ref": component_ref, "command_type": command_type, "command_id": command_id, **more}


async def _operating(stage: Stage, app: Application, component_ref: str, command_id: str) -> None:
    """Hold a component, with a command that runs."""
    await app.granted(BIND, component_ref=component_ref)
    await app.granted(EXECUTE, command_unit_list=[_unit(component_ref, command_id)])
    await stage.probe.hangs(component_ref)


async def _operates(app: Application, component_ref: str, command_id: str) -> None:
    """Run a command that ends at once."""
    await app.granted(EXECUTE, command_unit_list=[_unit(component_ref, command_id, "start")])
    expect("how `start` completed", await app.completed(command_id), {command_id: "OK"})


def _check_stopped(stage: Stage, *component_refs: str) -> None:
    units = [unit for params in stage.probe.params_of(EXECUTE) for unit in params["command_unit_list"]]
    stopped = {unit["component_ref"] for unit in units if unit["command_type"] == "stop"}
    missing = set(component_refs) - stopped
    if missing:
        raise Deviation(f"`stop` of {', '.join(sorted(missing))} to be run", f"that of {shown(stopped)}")


@CHECKS("lease-exclusive", *BOTH)
async def _lease_exclusive(stage: Stage) -> None:
    """An actuation component has one holder, with an epoch that grows; a client that queried is notified of changes."""
    arm = stage.ref("arm")
    app, other = await _leasing(stage), await _leasing(stage)
    free = await _lease(other, arm)
    expect("how things stand", (free["state"], free["waiting"], free["position"]), ("FREE", 0, 0))
    await app.granted(BIND, component_ref=arm)
    mine = await _lease(app, arm)
    expect("the state for who holds it", mine["state"], "MINE")
    seen = await _told(other, arm, "HELD")
    expect("the epoch and holder", (seen["epoch"], seen["holder"]), (mine["epoch"], mine["holder"]))
    await other.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)
    await other.refused(EXECUTE, "OUT_OF_RESOURCES", command_unit_list=[_unit(arm, "c")])
    await app.granted(RELEASE, component_ref=arm)
    await _told(other, arm, "FREE")
    await other.granted(BIND, component_ref=arm)
    theirs = await _lease(other, arm)
    expect("the state for who holds it", theirs["state"], "MINE")
    expect("whether the epoch has grown", theirs["epoch"] > mine["epoch"], True)
    await _told(app, arm, "HELD", epoch=theirs["epoch"])


@CHECKS("lease-of-what", *BOTH)
async def _lease_of_what(stage: Stage) -> None:
    """A component without actuation has no lease, and an unknown component is refused alike."""
    app = await _leasing(stage)
    for method in (LOOK, REQUEST, LEAVE):
        for component_ref in (stage.ref("eye"), stage.ref("tool"), "conformance-nowhere/arm", ""):
            await app.refused(method, "UNSUPPORTED", component_ref=component_ref)
        await app.error(method, -32602)
    for method in (GRANT, DECLINE):
        await app.refused(method, "UNSUPPORTED", request_id="conformance-nothing")


@CHECKS("lease-base", *BOTH)
async def _lease_base(stage: Stage) -> None:
    """A client that neither names leases in its hello nor calls a method of them gets no notifications of leases."""
    arm = stage.ref("arm")
    other, base, greeted = await _leasing(stage), await stage.application(), await stage.application()
    await greeted.granted("openrois.hello", version="1", extensions=["rois.stream"])
    for app in (base, greeted):
        await _operating(stage, app, arm, "h")
        asked = (await other.granted(REQUEST, component_ref=arm))["lease"]
        expect("how things stand", (asked["state"], asked["position"]), ("HELD", 1))
        await app.silent("it has not asked for leases")
        await app.granted(RELEASE, component_ref=arm)
        await _told(other, arm, "MINE")
        await app.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)
        await stage.probe.finish(arm)
        expect("how the command completed", await app.completed("h"), {"h": "OK"})
        await app.silent("it has not asked for leases")
        await other.granted(RELEASE, component_ref=arm)
    named = await stage.application()
    await named.granted("openrois.hello", version="1", extensions=["openrois.lease"])
    await named.granted(BIND, component_ref=arm)
    await other.granted(REQUEST, component_ref=arm)
    await _asked(named, arm)


@CHECKS("lease-hand-over", *BOTH)
async def _lease_hand_over(stage: Stage) -> None:
    """The holder is asked; declined, the request waits on; granted, what runs is stopped and ends with ABORT."""
    arm = stage.ref("arm")
    app, other = await _leasing(stage), await _leasing(stage)
    await _operating(stage, app, arm, "h")
    await other.granted(REQUEST, component_ref=arm)
    request_id = await _asked(app, arm)
    for method in (GRANT, DECLINE):
        await other.refused(method, "UNSUPPORTED", request_id=request_id)
    await app.granted(DECLINE, request_id=request_id)
    declined = await other.next("openrois.lease.declined")
    expect("what was declined", (declined["component_ref"], declined["request_id"]), (arm, request_id))
    expect("the position of who was declined", (await _lease(other, arm))["position"], 1)
    answer = await other.granted(REQUEST, component_ref=arm)
    expect("the request_id", answer["request_id"], await _asked(app, arm))
    await app.granted(GRANT, request_id=answer["request_id"])
    expect("how what ran there completed", await app.completed("h"), {"h": "ABORT"})
    await _told(other, arm, "MINE")
    await _told(app, arm, "HELD")
    _check_stopped(stage, arm)
    await app.refused(EXECUTE, "OUT_OF_RESOURCES", command_unit_list=[_unit(arm, "i")])
    await _operates(other, arm, "j")


async def _asked(holder: Application, component_ref: str) -> str:
    """Wait until the holder is asked for a component; return the request_id."""
    asked = await holder.next("openrois.lease.requested")
    expect("what it is asked for", asked["component_ref"], component_ref)
    if not asked["request_id"] or not asked["subject"] or not asked["answer_ms"]:
        raise Deviation("a request_id, who asks, and the time for an answer", shown(asked))
    return str(asked["request_id"])


@CHECKS("lease-queue", *BOTH)
async def _lease_queue(stage: Stage) -> None:
    """A waiting client learns its position; leaving is notified to the holder; the first gets what is released."""
    arm = stage.ref("arm")
    app, first, second = [await _leasing(stage) for _ in range(3)]
    await app.granted(BIND, component_ref=arm)
    for position, each in enumerate((first, second), 1):
        lease = (await each.granted(REQUEST, component_ref=arm))["lease"]
        expect("the state, position and how many wait", [lease[name] for name in ("state", "position", "waiting")],
               ["HELD", position, position])  # fmt: skip
    request_id = await _asked(app, arm)
    await first.granted(LEAVE, component_ref=arm)
    withdrawn = await app.next("openrois.lease.withdrawn")
    expect("which request is withdrawn", withdrawn["request_id"], request_id)
    await app.refused(GRANT, "UNSUPPORTED", request_id=request_id)
    await _told(second, arm, "HELD", position=1, waiting=1)
    await app.granted(RELEASE, component_ref=arm)
    await _told(second, arm, "MINE")
    left = await _lease(first, arm)
    expect("how things stand for who has left", (left["state"], left["position"]), ("HELD", 0))
    await _operates(second, arm, "s")


@CHECKS("lease-take", *BOTH, Needs.ADMINISTRATOR)
async def _lease_take(stage: Stage) -> None:
    """An administrator takes a component; its holder, of the base wire, sees its commands end with ABORT, no more."""
    arm = stage.ref("arm")
    plain, chief = await stage.application(), await _leasing(stage)
    await _operating(stage, plain, arm, "h")
    expect("the state", (await chief.granted(TAKE, component_ref=arm))["lease"]["state"], "MINE")
    expect("how what ran there completed", await plain.completed("h"), {"h": "ABORT"})
    _check_stopped(stage, arm)
    await plain.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)
    await plain.silent("it has used no extension")
    await _operates(chief, arm, "t")


async def _resumable(stage: Stage, app: Application) -> dict[str, Any] | None:
    """Return the token of an application's session and its grace; None where leases end with their connection."""
    answer = await app.ask(TOKEN)
    if answer["return_code"] != "UNSUPPORTED":
        return answer
    stage.remark("leases do not survive a lost connection at this gateway")
    return None


@CHECKS("lease-resume", *BOTH)
async def _lease_resume(stage: Stage) -> None:
    """A lost session is resumed by its token, once: with its leases, in their epochs, and the ends of its commands."""
    arm = stage.ref("arm")
    app, witness = await _leasing(stage), await _leasing(stage)
    if (answer := await _resumable(stage, app)) is None:
        return
    expect("the return_code, and whether there is time", (answer["return_code"], answer["grace_ms"] > 0), ("OK", True))
    await _operating(stage, app, arm, "h")
    epoch = (await _lease(witness, arm))["epoch"]
    app.socket.transport.abort()
    await _told(witness, arm, "ABSENT", epoch=epoch)
    await witness.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)
    await stage.probe.finish(arm)
    again, thief = await _leasing(stage), await _leasing(stage)
    resumed = await again.granted(RESUME, token=answer["token"], command_ids=["h", "never"])
    expect("the leases", resumed["leases"], [{"component_ref": arm, "epoch": epoch}])
    expect("the commands that are not known", resumed["forgotten"], ["never"])
    expect("whether there is another token", bool(resumed["token"]) and resumed["token"] != answer["token"], True)
    expect("how the command completed", await again.completed("h"), {"h": "OK"})
    await _told(witness, arm, "HELD", epoch=epoch)
    await _operates(again, arm, "i")
    for token in ("conformance-guess", answer["token"]):
        await thief.refused(RESUME, "UNSUPPORTED", token=token)
    expect("the state for who has resumed", (await _lease(again, arm))["state"], "MINE")


@CHECKS("lease-resume-open", *BOTH)
async def _lease_resume_open(stage: Stage) -> None:
    """The token of a connection that is still open moves its leases, in new epochs; that connection is closed."""
    arm = stage.ref("arm")
    app, again = await _leasing(stage), await _leasing(stage)
    if (answer := await _resumable(stage, app)) is None:
        return
    await _operating(stage, app, arm, "h")
    before = (await _lease(app, arm))["epoch"]
    resumed = await again.granted(RESUME, token=answer["token"], command_ids=["h"])
    expect("the components that it has", [lease["component_ref"] for lease in resumed["leases"]], [arm])
    expect("whether the epoch has grown", resumed["leases"][0]["epoch"] > before, True)
    expect("the code with which the former connection is closed", (await app.closed())[0], RESUMED)
    await stage.probe.finish(arm)
    expect("how the command completed", await again.completed("h"), {"h": "OK"})
    await _operates(again, arm, "i")


@CHECKS("lease-ends", *BOTH)
async def _lease_ends(stage: Stage) -> None:
    """A session that has no token, or that closes its connection, gives back at once what it holds."""
    arm = stage.ref("arm")
    witness = await _leasing(stage)
    for closes in (False, True):
        app = await _leasing(stage)
        if closes:
            await app.ask(TOKEN)
        await app.granted(BIND, component_ref=arm)
        await _told(witness, arm, "HELD")
        if closes:
            await app.socket.close()
        else:
            app.socket.transport.abort()
        told = await witness.next("openrois.lease.changed")
        expect("the state", told["state"], "FREE")


@CHECKS("stop-all", *BOTH)
async def _stop_all(stage: Stage) -> None:
    """`openrois.stop_all` stops all that acts on an engine, for any operator, before requests that its session sent."""
    arm, leg = stage.ref("arm"), stage.ref("leg")
    app, plain = await _leasing(stage), await stage.application()
    await _operating(stage, app, arm, "h")
    await _operating(stage, plain, leg, "l")
    await app.granted(EXECUTE, command_unit_list=[_unit(arm, "later", delay_time=_HOUR)])
    query = {"query_type": "component_status", "condition": f"component_ref = '{stage.ref('eye')}'"}
    stage.probe.engine.answers["rois.query.query"] = SILENCE
    flood = [await app.begin("rois.query.query", **query) for _ in range(FLOOD)]
    answer = await app.granted(STOP_ALL, component_ref=arm)
    if not {arm, leg} <= set(answer["stopped"]) or answer["failed"]:
        raise Deviation(f"{arm} and {leg} among what has stopped, and nothing that has not", shown(answer))
    _check_stopped(stage, arm, leg)
    expect("how the commands completed", await app.completed("h", "later"), {"h": "ABORT", "later": "ABORT"})
    expect("how the other's command completed", await plain.completed("l"), {"l": "ABORT"})
    await plain.silent("it has used no extension")
    await (await stage.application()).granted(STOP_ALL, component_ref=arm)
    stage.probe.engine.answers.clear()
    await stage.probe.answer_held()
    for each in flood:
        await app.result("rois.query.query", each)
    # It is no latch.
    await _operates(app, arm, "i")
    await app.refused(STOP_ALL, "BAD_PARAMETER", component_ref=arm, engine_id=stage.probe.engine.engine_id)
    await app.refused(STOP_ALL, "UNSUPPORTED", engine_id="conformance-nowhere")
