"""The page of an operator elsewhere: over TLS with a token, from a refused token to one that has ended."""

import ssl
import time
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect
from websockets.asyncio.client import ClientConnection

from openrois.transport.credentials import Credentials
from tests.support.browser import GATEWAY_AWAY, Visit, visiting
from tests.support.certificates import Authority
from tests.support.conversation import all_stopped
from tests.support.guarded import Guarded, ask, fresh, guarded
from tests.support.operated import noting_avatar

pytestmark = [
    pytest.mark.browser,
    pytest.mark.asyncio(loop_scope="session"),
    pytest.mark.usefixtures("devices"),
]

_REFUSED = (GATEWAY_AWAY, r"Failed to load resource.* 401")
_MICROPHONE = "openrois.microphone.status === 'STREAMING_RUNNING'"


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def coming(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Guarded]:
    """A gateway with TLS that asks for tokens, and an avatar behind it, whose picture is small."""
    folder = tmp_path_factory.mktemp("gateway")
    authority = Authority(folder)
    cert, key = authority.issue()
    revoked = folder / "revoked"
    revoked.write_text("")
    shown = Credentials(fresh(sub="avatar", roles="adapter", scope=["avatar/*"]), authority.file)
    async with (
        guarded(folder, tls_cert=cert, tls_key=key, auth_revocations=revoked) as coming,
        noting_avatar(folder, f"{coming.address}adapter", shown),
    ):
        yield coming


async def _give(visit: Visit, token: str) -> None:
    await visit.item("token").fill(token)
    await visit.item("token").press("Enter")


@pytest.mark.long
async def test_operator_with_a_token_operates_until_it_ends(browser: Browser, coming: Guarded) -> None:
    url = coming.gateway.url
    async with visiting(browser, url, tolerated=_REFUSED, ignore_https_errors=True) as visit:
        await expect(visit.item("banner")).to_contain_text("The gateway asks for a token")
        await _give(visit, fresh(exp=int(time.time()) - 100, iat=int(time.time()) - 200, sub="anna"))
        await expect(visit.item("banner")).to_contain_text("Your token has ended")
        await _give(visit, fresh(sub="anna") + "x")
        await expect(visit.item("banner")).to_contain_text("does not take this token")

        await _give(visit, fresh(sub="anna", jti="first"))
        await visit.no_banner()
        await visit.plays()
        await visit.press("microphone-toggle")
        await visit.until(_MICROPHONE)
        await expect(visit.item("handover")).to_contain_text("Microphone is on: you have control")
        stream_id = await visit.stream_id("microphone")
        await visit.item("say-text").fill("Hi.")
        await visit.item("say-text").press("Enter")
        await expect(visit.item("say-state")).to_have_attribute("data-state", "done")
        await visit.item("say-text").fill("This is not heard to its end. " * 12)
        await visit.item("say-text").press("Enter")
        await expect(visit.item("say-state")).to_have_attribute("data-state", "speaking")
        await visit.until_executed("avatar/speech_synthesizer", "start")
        await visit.press("stop-all")
        await all_stopped(visit)
        await expect(visit.item("say-state")).to_have_attribute("data-state", "stopped")
        # Neither the end of a speech nor STOP takes the microphone.
        assert await visit.read(_MICROPHONE)
        assert await visit.stream_id("microphone") == stream_id
        await visit.press("camera-toggle")
        await visit.until("openrois.camera.status === 'STREAMING_RUNNING'")
        # Control is given back with the last of them.
        await visit.press("microphone-toggle")
        await expect(visit.item("handover")).to_contain_text("Camera is on: you have control")
        await expect(visit.item("camera-toggle")).to_contain_text("Sent")

        (coming.folder / "revoked").write_text("jti first\n")
        await expect(visit.item("banner")).to_contain_text("Your token has ended")
        for item in ("sending", "handover"):
            await expect(visit.item(item)).to_be_hidden()
        assert await visit.read("openrois.client.state.retryAt === Infinity")
        await _give(visit, fresh(sub="anna"))
        await visit.no_banner()


async def test_viewer_sees_the_picture_and_why_controls_are_disabled(browser: Browser, coming: Guarded) -> None:
    page = f"{coming.gateway.url}#token={fresh(sub='eve', roles='viewer')}"
    async with visiting(browser, page, ignore_https_errors=True) as visit:
        await visit.plays()
        await expect(visit.item("handover")).to_contain_text("You are watching")
        names = ("say-text", "say-send", "microphone-toggle", "camera-toggle", "stop-all", "control-toggle")
        reaction = visit.page.locator("button.reaction").first
        for item in (*map(visit.item, names), reaction):
            await expect(item).to_be_disabled()
            await expect(item).to_have_accessible_description(
                "You are watching: your token does not let you operate the body"
            )


_DARK = """
    const page = { engineId: "avatar", video: "disconnected", audio: "disconnected", muted: false, statistics: false };
    sessionStorage.setItem("openrois.page", JSON.stringify({ ...page, picture: "", at: Date.now() }));
"""
"""A page that is loaded again as it was left: picture and sound, which keep a slow machine busy, are off."""


@pytest.mark.long
async def test_control_is_requested_kept_and_handed_over(browser: Browser, coming: Guarded) -> None:
    url, trust = coming.gateway.url, ssl.create_default_context(cafile=coming.folder / "ca.pem")
    async with (
        visiting(browser, f"{url}#token={fresh(sub='anna')}", script=_DARK, ignore_https_errors=True) as anna,
        visiting(browser, f"{url}#token={fresh(sub='ben')}", script=_DARK, ignore_https_errors=True) as ben,
        coming.dial(fresh(sub="carl"), ssl=trust) as carl,
    ):
        theirs, ours = (visit.item("handover") for visit in (anna, ben))
        await anna.press("control-toggle")
        await expect(ours).to_contain_text("anna has control")
        await expect(theirs).to_be_hidden()
        seat = {"component_ref": "avatar/teleoperation"}
        assert (await ask(carl, "openrois.lease.request", **seat))["result"]["lease"]["position"] == 1
        for item in (ben.item("control-toggle"), ben.page.locator("button.reaction").first):
            await expect(item).to_be_disabled()
            await expect(item).to_have_accessible_description("anna has control")
        await ben.press("handover-yes")
        await expect(ours).to_contain_text("You wait for control: number 2 in line")

        # One after the other is answered.
        await expect(theirs).to_contain_text("carl asks for control, and 1 more")
        await anna.press("handover-no")
        await expect(theirs).to_contain_text("ben asks for control")
        await anna.press("handover-no")
        await expect(theirs).to_be_hidden()
        await expect(ours).to_contain_text("anna does not hand over control now. You wait: number 2 in line")
        await ask(carl, "openrois.lease.leave", **seat)
        await expect(ours).to_contain_text("number 1 in line")
        await expect(anna.item("control-toggle")).to_have_attribute("aria-pressed", "true")

        await ben.press("handover-yes")
        await expect(theirs).to_contain_text("ben asks for control")
        await anna.press("handover-yes")
        # What stands on each page is one sentence, not two that contradict each other.
        await expect(ben.item("control-toggle")).to_have_attribute("aria-pressed", "true")
        await expect(ben.item("control-words")).to_have_text("You have control")
        await expect(ours).to_be_hidden()
        await expect(theirs).to_contain_text("ben has control")
        await expect(anna.item("control-toggle")).to_have_attribute("aria-pressed", "false")
        await expect(anna.item("control-words")).to_have_text("You have handed over control to ben.")
        # Who does not drive stops everything all the same.
        await anna.press("stop-all")
        await all_stopped(anna)
        await expect(ben.item("control-words")).to_have_text("Everything was stopped by anna")
        for bar in (ours, theirs):
            await expect(bar).to_be_hidden()


async def test_a_person_stops_for_programs_and_another_hands_back(browser: Browser, coming: Guarded) -> None:
    url, trust = coming.gateway.url, ssl.create_default_context(cafile=coming.folder / "ca.pem")
    anna_page, ben_page = (f"{url}#token={fresh(sub=sub, rank='person')}" for sub in ("anna", "ben"))
    part = {"component_ref": "avatar/reaction"}

    async def try_to_move(agent: ClientConnection, command_id: str) -> str:
        unit = {**part, "command_type": "start", "command_id": command_id, "arguments": []}
        answer = await ask(agent, "rois.command.execute", command_unit_list=[unit])
        return str(answer["result"]["return_code"])

    async with (
        visiting(browser, anna_page, script=_DARK, ignore_https_errors=True) as anna,
        coming.dial(fresh(sub="agent", rank="agent"), ssl=trust) as agent,
    ):
        assert (await ask(agent, "rois.command.bind", **part))["result"]["return_code"] == "OK"
        await expect(anna.item("stopped")).to_be_hidden()
        await anna.press("stop-all")
        await all_stopped(anna)
        await expect(anna.item("stopped")).to_contain_text("anna has stopped avatar. Programs wait.")
        for number in range(200):
            assert await try_to_move(agent, f"try {number}") == "OUT_OF_RESOURCES"
        # A page that comes later knows it, too, and its visitor may hand the body back.
        async with visiting(browser, ben_page, script=_DARK, ignore_https_errors=True) as ben:
            await expect(ben.item("stopped")).to_contain_text("anna has stopped avatar. Programs wait.")
            await ben.press("stopped-hand-back")
            for visit in (ben, anna):
                await expect(visit.item("stopped")).to_be_hidden()
        assert await try_to_move(agent, "after") == "OK"
