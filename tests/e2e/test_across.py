"""The page at one gateway shows and commands a body whose adapter is at another one, and goes on when one is killed."""

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Final

import pytest
from openrois_media import VideoSource, serve
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import ColourBars
from playwright.async_api import Browser, expect

from openrois.adapter.components import SpeechSynthesis
from openrois.testing import FaultRelay
from openrois.types.references import reference
from tests.support.browser import GATEWAY_AWAY, visiting
from tests.support.conversation import say
from tests.support.gateway_processes import gateway_processes, until
from tests.support.loopback import some_address
from tests.support.media_body import ENGINE, Body
from tests.support.nats import NatsServer
from tests.support.place import owned_by, place_of
from tests.support.postgres import Server
from tests.support.proxies import proxy, shipped_proxy

pytestmark = [
    pytest.mark.browser,
    pytest.mark.asyncio(loop_scope="session"),
    pytest.mark.usefixtures("haproxy"),
]

VOICE: Final = reference(ENGINE, SpeechSynthesis.component_type.name)

IDLE: Final = 60.0
"""Seconds after which haproxy cuts what is idle: longer than a test."""


class Speaker(SpeechSynthesis):
    """Keeps what it was to say."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str | None] = []

    async def start(self) -> None:
        """Say it."""
        self.said.append(self.speech_text)


def no_sessions(body: Body) -> Callable[[], Awaitable[bool]]:
    """Tell whether a body has no streams."""

    async def is_so() -> bool:
        return not body.sessions

    return is_so


async def test_a_page_at_another_gateway_sees_and_commands_the_body(
    browser: Browser, shared_nats: NatsServer, postgres_server: Server, tmp_path: Path
) -> None:
    with some_address():
        async with place_of(shared_nats, postgres_server, "a", "b") as place:
            owner, front = place.gateway("a"), place.gateway("b")
            async with (
                FaultRelay(owner.url.replace("http", "ws", 1)) as relay,
                proxy(front.url, folder=tmp_path, idle=IDLE) as way,
            ):
                speaker = Speaker()
                body = Body(owner, relay, others=(speaker,))
                await body.start()
                try:
                    await owned_by(place, "a")
                    async with visiting(browser, way.url) as visit:
                        await visit.plays()
                        await visit.shows()
                        await visit.status("video", "RUNNING")
                        await say(visit, "Hello from another gateway.")
                        await expect(visit.item("say-state")).to_have_attribute("data-state", "done")
                        assert speaker.said == ["Hello from another gateway."]

                        # Control that is taken at the owner is told at the page, and its end.
                        other = await place.app("a")
                        assert await other.code("rois.command.bind", component_ref=VOICE) == "OK"
                        await expect(visit.item("handover")).to_contain_text("Another visitor has control")
                        assert await other.code("rois.command.release", component_ref=VOICE) == "OK"
                        await expect(visit.item("handover")).to_be_hidden()
                        await visit.plays()
                    # With the page its streams end at the adapter.
                    await until(no_sessions(body), "streams of a page that is gone go on")
                finally:
                    await body.close()


@pytest.mark.long
@pytest.mark.media
@pytest.mark.parametrize("killed", ["that of the body", "that of the page"])
async def test_the_page_goes_on_when_a_gateway_is_killed(
    browser: Browser, shared_nats: NatsServer, postgres_server: Server, tmp_path: Path, killed: str
) -> None:
    bars = VideoSource(ColourBars(320, 180, clock=SystemClock()), size=(320, 180))
    with some_address():
        async with gateway_processes(shared_nats, postgres_server, tmp_path) as gateways:
            urls = [each.url for each in gateways.gateways.values()]
            async with serve(engine_id=ENGINE, streams={"camera": bars}, gateway=urls):
                owner = await gateways.owner(ENGINE)
                front, other = gateways.others(owner.gateway_id)
                async with (
                    shipped_proxy(front.url, other.url, owner.url, balance="first") as way,
                    visiting(browser, way.url, tolerated=[GATEWAY_AWAY]) as visit,
                ):
                    await visit.plays()
                    await visit.status("video", "RUNNING")
                    former = await visit.stream_id("video")
                    await (owner if killed == "that of the body" else front).kill()
                    await visit.another_stream("video", than=former)
                    await visit.status("video", "RUNNING")
                    await visit.plays()
                    await visit.no_banner()
