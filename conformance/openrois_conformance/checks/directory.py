"""The extension `openrois.directory`: engines in pages, their profiles by version, and what has changed."""

from typing import Any, Final

from openrois_conformance.application import Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()
BOTH: Final = (Needs.ADAPTER, Needs.DIRECTORY)

LIST: Final = "openrois.directory.list"
READ: Final = "openrois.directory.read"
PROFILES: Final = "openrois.directory.profiles"
CHANGED: Final = "openrois.directory.changed"


async def _listed(app: Application, limit: int, **params: Any) -> list[dict[str, Any]]:
    """Return the entries of all pages."""
    entries: list[dict[str, Any]] = []
    after = ""
    while True:
        page = await app.granted(LIST, after=after, limit=limit, **params)
        entries += page["engines"]
        if len(page["engines"]) > limit:
            raise Deviation(f"at most {limit} engines", f"{len(page['engines'])}")
        if not page["next"]:
            return entries
        if page["next"] <= after:
            raise Deviation(f"a next page behind {after!r}", shown(page["next"]))
        after = page["next"]


@CHECKS("directory-list", *BOTH)
async def _list(stage: Stage) -> None:
    """The pages of `openrois.directory.list` have every engine of the profile once, with what it owns."""
    app = await stage.application()
    for limit in (1, 100):
        entries = await _listed(app, limit)
        ids = [entry["engine_id"] for entry in entries]
        expect(f"the engines in pages of {limit}", ids, sorted((await app.tree()).engine_ids()))
    own = next(entry for entry in entries if entry["engine_id"] == stage.probe.engine.engine_id)
    refs = [each["component_ref"] for each in own["components"]]
    mine = sorted(ref for ref in stage.probe.engine.profiles if ref.startswith(f"{own['engine_id']}/"))
    expect("what the suite's engine owns", sorted(refs), mine)
    urn = own["components"][0]["component_type"]
    having = [entry["engine_id"] for entry in await _listed(app, 100, component_types=[urn])]
    if own["engine_id"] not in having:
        raise Deviation(f"{own['engine_id']} among the engines with a {urn}", shown(having))
    expect("the engines with what does not exist", await _listed(app, 100, component_types=["urn:none"]), [])


@CHECKS("directory-read", *BOTH)
async def _read(stage: Stage) -> None:
    """An engine is read as it is listed, and its profiles by their versions as `get_profile` has them."""
    app = await stage.application()
    engine_id = stage.probe.engine.engine_id
    (entry,) = (each for each in await _listed(app, 100) if each["engine_id"] == engine_id)
    expect("the entry", (await app.granted(READ, engine_ids=[engine_id, "conformance-none"]))["engines"], [entry])
    whole = (await app.granted("rois.system.get_profile"))["component_profiles"]
    left = [each["component_ref"] for each in entry["components"]]
    profiles: dict[str, Any] = {}
    while left:
        answer = await app.granted(PROFILES, component_refs=left)
        if len(answer["left"]) >= len(left):
            raise Deviation("fewer components left than asked for", shown(answer["left"]))
        profiles |= answer["profiles"]
        left = answer["left"]
    for each in entry["components"]:
        expect(
            f"the profile of {each['component_ref']}", profiles[each["profile_version"]], whole[each["component_ref"]]
        )


@CHECKS("directory-changed", *BOTH)
async def _changed(stage: Stage) -> None:
    """An application that names the extension learns which engine came and which has gone, and nothing else of it."""
    app = await stage.application()
    await app.granted("openrois.hello", version="1", extensions=["openrois.directory"])
    adapter = await stage.attached()
    engine_id = adapter.engine.engine_id
    while engine_id not in (notice := await app.next(CHANGED))["changed"]:
        pass
    expect("what has gone", engine_id in notice["gone"], False)
    await adapter.socket.close()
    while engine_id not in (await app.next(CHANGED))["gone"]:
        pass
    if any(method == "rois.system.profile_changed" for method, _ in app.unread):
        raise Deviation("no profile_changed", "one")
