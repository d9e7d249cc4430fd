"""Wrong frames of a WebSocket: the connection ends with the right code, and no other connection notices."""

import asyncio
from contextlib import suppress
from pathlib import Path

import pytest

from openrois.gateway.server import Gateway
from openrois.gateway.socket import SocketProfile
from tests.support import deployment
from tests.support.deployment import Application
from tests.support.frame_cases import CASES, WITH_HANDSHAKE, Case
from tests.support.frames import CONTINUATION, PING, PONG, TEXT, asks, frame, raw_client, request

KIB = 1024

AT_A_TIME = 100


async def tried(gateway: Gateway, case: Case) -> list[str]:
    """Return what is received for a case; where the connection goes on, up to the answer of another request."""
    async with raw_client(gateway.url) as client:
        if case.later:
            await client.send([asks(0)])
            assert await client.hears("answer 0") == ["answer 0"]
        await client.send(case.sent)
        if any(said.startswith("close") for said in case.heard):
            heard = await client.hears()
            await client.ends()
            return heard
        await client.send([asks(99)])
        heard = await client.hears("answer 99")
        return heard[:-1] if heard[-1] == "answer 99" else heard


async def test_every_case_has_its_outcome(caplog: pytest.LogCaptureFixture) -> None:
    assert len({case.name for case in CASES}) == len(CASES) > 150
    places = asyncio.Semaphore(AT_A_TIME)
    wrong: dict[str, list[str]] = {}

    async def try_one(case: Case) -> None:
        async with places:
            heard = await tried(gateway, case)
        if heard != list(case.heard):
            wrong[case.name] = heard

    async with deployment.gateway() as gateway, deployment.patience(), asyncio.TaskGroup() as trying:
        for case in CASES:
            trying.create_task(try_one(case))
    assert wrong == {}
    assert not [record for record in caplog.records if record.exc_info]


async def test_what_comes_with_the_handshake_is_judged_too(gateway: Gateway) -> None:
    """It may not come before the answer, but it does not have to be refused either."""
    for case in WITH_HANDSHAKE:
        first, *rest = case.sent
        async with raw_client(gateway.url, with_handshake=first) as client, deployment.patience():
            await client.send(rest)
            assert await client.hears(case.heard[-1]) == list(case.heard), case.name


async def test_an_adapter_is_judged_like_an_application(gateway: Gateway) -> None:
    for wrong, code in ((frame(TEXT, b"{}", mask=None), 1002), (frame(PONG) * 1100, 1008)):
        async with raw_client(gateway.url, "adapter") as client, deployment.patience():
            await client.send([wrong])
            assert (await client.hears())[-1] == f"close {code}"


FLOODS = {
    "pings": (b"", frame(PING, b"x" * 125) * 500),
    "pongs": (b"", frame(PONG, b"x" * 125) * 500),
    "fragments without anything": (frame(TEXT, fin=False), frame(CONTINUATION, fin=False) * 10_000),
    "fragments and pings": (
        frame(TEXT, b"[", fin=False),
        (frame(CONTINUATION, b" ", fin=False) + frame(PING, b"x" * 125)) * 500,
    ),
    "one message that does not end": (frame(TEXT, fin=False), frame(CONTINUATION, bytes(KIB), fin=False) * 64),
    "frames without a mask": (b"", frame(TEXT, bytes(KIB), mask=None) * 64),
}
MEBIBYTE = 1 << 20


def memory() -> int:
    """Return the bytes that this process has in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.parametrize("reads", [True, False])
async def test_floods_end_and_cost_no_memory_and_no_other_connection(
    gateway: Gateway, app: Application, reads: bool
) -> None:
    async def flood(first: bytes, chunk: bytes) -> None:
        async with raw_client(gateway.url, is_small=not reads) as client:
            await client.send([first])
            listening = asyncio.ensure_future(client.hears() if reads else asyncio.sleep(0, []))
            await client.floods(chunk)
            with suppress(ConnectionError):
                said = (await listening)[-1:]
                assert said in ([], ["end"], ["close 1002"], ["close 1008"], ["close 1009"])

    await app.settled()
    before = memory()
    async with deployment.patience():
        floods = [asyncio.ensure_future(flood(*each)) for each in FLOODS.values()]
        most = answered = 0
        while not all(each.done() for each in floods):
            assert await app.code("rois.query.query", query_type="brightness") == "OK"
            answered += 1
            most = max(most, memory())
        await asyncio.gather(*floods)
    assert answered > len(floods)
    assert most - before < 16 * MEBIBYTE


QUICK = SocketProfile(max_message=64 * KIB, ping_interval=0.02, ping_timeout=0.1)


async def test_a_frame_that_never_comes_whole_is_no_answer_to_a_ping() -> None:
    async with deployment.gateway(application=QUICK, adapter=QUICK) as gateway, deployment.patience():
        for sent in (b"\x81", b"\x81\xfe", b"\x81\xfe\x01", asks(1)[:-1], frame(TEXT, length=60_000), b"\x8a\x80"):
            async with raw_client(gateway.url) as client:
                await client.send([sent])
                assert await client.hears() == ["end"]


async def test_a_client_that_pings_and_reads_no_answers_is_cut() -> None:
    """Long answers fill what the kernel keeps, so that the pong has to wait; behind it nothing is read any more."""
    async with (
        deployment.gateway(application=QUICK) as gateway,
        raw_client(gateway.url, is_small=True) as client,
        deployment.patience(),
    ):
        await client.floods(frame(TEXT, request(1, note="x" * 60_000)) * 2 + frame(PING, b"x"))
