"""What becomes of streams when NATS, another gateway or the way between fails: each fault is a real one."""

import asyncio
import signal
from pathlib import Path
from typing import Any

import pytest

from openrois.cluster.connection import NatsConnection
from openrois.cluster.dial_failed import DialFailed
from openrois.cluster.link import NatsLink, NatsStream
from openrois.testing.relay import FaultRelay, Weather
from openrois.transport.stream import StreamClosed
from tests.support.nats import (
    NatsServer,
    cluster_name,
    dialled,
    echo,
    ended,
    freeze,
    links,
    nats_server,
    settings,
    stand_in,
)
from tests.support.nats_child import gateway_process

pytestmark = pytest.mark.extra(name="cluster")
PATIENCE = 30.0


async def back(near: NatsLink, gateway_id: str) -> NatsStream:
    """Return a new stream as soon as there can be one."""
    async with asyncio.timeout(PATIENCE):
        while True:
            try:
                return await near.dial(gateway_id, {})
            except DialFailed:
                await asyncio.sleep(0.02)


async def until_present(near: NatsLink, *gateway_ids: str) -> None:
    """Wait until these gateways are there and no other."""
    changed = asyncio.Event()
    leave = near.on_presence(lambda _present: changed.set())
    async with asyncio.timeout(PATIENCE):
        while set(near.present) != set(gateway_ids):
            changed.clear()
            await changed.wait()
    leave()


class Spy:
    """Reads all that is published in a cluster, as a NATS server delivers it."""

    def __init__(self) -> None:
        self.heard = b""

    async def listen(self, url: str, prefix: str) -> NatsConnection:
        connection = await NatsConnection.open(settings(url), url, "spy")
        connection.subscribe(f"{prefix}.>", self._hear)
        await connection.flush()
        return connection

    def _hear(self, _subject: bytes, _headers: bytes, payload: bytes) -> None:
        self.heard += payload


class TestNats:
    async def test_streams_are_lost_when_it_is_killed_and_there_are_new_ones_when_it_is_back(
        self, nats: None, tmp_path: Path
    ) -> None:
        with nats_server(tmp_path) as server:
            async with links(server.url, server.url) as (near, far):
                await far.listen(echo)
                stream = await near.dial("b", {})
                server.kill()
                closed = await ended(stream)
                assert closed.code == 1006
                with pytest.raises(StreamClosed):
                    await stream.send("x")
                assert not stream.send_now("x")
                with pytest.raises(DialFailed, match=r"gateway 'b' is not reached: .*NATS"):
                    await near.dial("b", {})
                assert near.trouble
                assert (near.present, len(near), len(far)) == ({}, 0, 0)
                server.start()
                again = await back(near, "b")
                await again.send("new")
                assert await again.receive() == "new"
                assert near.trouble == ""
                await until_present(near, "a", "b")

    async def test_nothing_of_an_old_stream_arrives_after_a_restart(self, nats: None, tmp_path: Path) -> None:
        prefix, spy = cluster_name(), Spy()
        with nats_server(tmp_path) as server:
            async with (
                links(server.url, server.url, prefix=prefix) as (near, far),
                dialled(near, far) as pair,
            ):
                here, there = await pair()
                # What is sent from now on stays in the buffers of this process, and of its kernel.
                server.freeze()
                sent = 0
                while here.send_now(f"old {sent} " + "x" * 100_000):
                    sent += 1
                assert sent > 3
                sending = asyncio.ensure_future(here.send("old and waiting" + "x" * 200_000))
                await asyncio.sleep(0)
                server.kill()
                with pytest.raises(StreamClosed) as raised:
                    await sending
                assert raised.value.code == 1006
                server.start()
                spying = await spy.listen(server.url, prefix)
                one, other = await pair_when_back(pair)
                await one.send("new")
                assert await other.receive() == "new"
                assert (await ended(there)).code == 1006
                await spying.flush()
                assert b"new" in spy.heard
                assert b"old" not in spy.heard
                spying.abort("over")

    async def test_streams_are_lost_while_it_is_frozen_and_nothing_of_them_arrives_when_it_goes_on(
        self, nats: None, tmp_path: Path
    ) -> None:
        with nats_server(tmp_path) as server:
            async with links(server.url, server.url) as (near, far), dialled(near, far) as pair:
                here, there = await pair()
                server.freeze()
                await here.send("old")
                dialling = asyncio.ensure_future(near.dial("b", {}))
                for end in (here, there):
                    assert (await ended(end)).code == 1006
                with pytest.raises(DialFailed):
                    await dialling
                with pytest.raises(DialFailed, match="NATS"):
                    await near.dial("b", {})
                server.thaw()
                one, other = await pair_when_back(pair)
                await one.send("new")
                assert await other.receive() == "new"

    async def test_a_dial_fails_while_it_is_frozen_and_that_is_not_known_yet(self, nats: None, tmp_path: Path) -> None:
        with nats_server(tmp_path) as server:
            async with links(server.url, server.url) as (near, far):
                await far.listen(echo)
                server.freeze()
                with pytest.raises(DialFailed) as raised:
                    await near.dial("b", {})
                assert raised.value.code == 1006
                server.thaw()
                await back(near, "b")

    async def test_a_gateway_begins_without_it(self, nats: None, tmp_path: Path) -> None:
        server = NatsServer(tmp_path)
        async with links(server.url) as (near,):
            assert near.trouble.startswith(f"NATS at {server.url} is not reached: ")
            with pytest.raises(DialFailed, match="gateway 'b' is not reached: NATS at"):
                await near.dial("b", {})
            await near.listen(echo)
            try:
                server.start()
                await until_present(near, "a")
                await (await near.dial("a", {})).send("x")
            finally:
                server.kill()

    async def test_another_server_takes_over(self, nats: None, tmp_path: Path) -> None:
        prefix = cluster_name()
        with nats_server(tmp_path) as first, nats_server(tmp_path) as second:
            named = settings(first.url, prefix)
            both = type(named)((first.url, second.url), prefix=prefix)
            async with NatsLink(both, "a") as near, NatsLink(both, "b") as far:
                await far.listen(echo)
                lost = await near.dial("b", {})
                first.kill()
                assert (await ended(lost)).code == 1006
                stream = await back(near, "b")
                await stream.send("x")
                assert await stream.receive() == "x"

    async def test_messages_are_cut_to_what_it_takes(self, nats: None, tmp_path: Path) -> None:
        text = "x" * 3_000_000
        with nats_server(tmp_path, "max_payload: 65536") as server:
            async with links(server.url, server.url) as (near, far), dialled(near, far) as pair:
                here, there = await pair()
                sending = asyncio.ensure_future(here.send_many([text, *["y" * 1000] * 200]))
                assert await there.receive() == text
                assert [await there.receive() for _ in range(200)] == ["y" * 1000] * 200
                await sending
                assert not here.send_now("x" * 65_536)

    async def test_one_that_takes_too_little_is_no_use_and_that_is_said(self, nats: None, tmp_path: Path) -> None:
        with nats_server(tmp_path, "max_payload: 1024") as server:
            async with links(server.url) as (near,):
                assert near.trouble == (
                    f"NATS at {server.url} takes 1024 bytes at a time: set its max_payload to 49152 or more"
                )

    async def test_streams_are_lost_when_it_gives_up_a_gateway_that_reads_too_slowly(
        self, nats: None, tmp_path: Path
    ) -> None:
        # It keeps little for a gateway; what it would drop ends the connection.
        with nats_server(tmp_path, "max_pending: 300000\nmax_payload: 65536") as server:
            async with (
                FaultRelay(server.url, weather=Weather(rate=400_000)) as relay,
                links(server.url, relay.url) as (near, far),
                dialled(near, far) as pair,
            ):
                ends = [await pair() for _ in range(20)]
                sending = [asyncio.ensure_future(here.send("x" * 5_000_000)) for here, _ in ends]
                for each in sending:
                    with pytest.raises(StreamClosed) as raised:
                        await each
                    assert raised.value.code == 1006
                for _, there in ends:
                    assert (await ended(there)).code == 1006


async def pair_when_back(pair: Any) -> tuple[NatsStream, NatsStream]:
    async with asyncio.timeout(PATIENCE):
        while True:
            try:
                ends: tuple[NatsStream, NatsStream] = await pair()
            except DialFailed:
                await asyncio.sleep(0.02)
            else:
                return ends


class TestWay:
    """The way of one gateway to NATS goes through a relay."""

    async def test_both_ends_notice_that_the_way_is_cut(self, shared_nats: NatsServer) -> None:
        async with FaultRelay(shared_nats.url) as relay, links(shared_nats.url, relay.url) as (near, far):
            await far.listen(echo)
            stream = await near.dial("b", {})
            await stream.send("x")
            assert await stream.receive() == "x"
            relay.cut()
            assert (await ended(stream)).code == 1006
            again = await back(near, "b")
            await again.send("x")
            assert await again.receive() == "x"

    async def test_both_ends_notice_that_the_way_is_half_open(self, shared_nats: NatsServer) -> None:
        async with (
            FaultRelay(shared_nats.url) as relay,
            links(shared_nats.url, relay.url) as (near, far),
            dialled(near, far) as pair,
        ):
            here, there = await pair()
            relay.half_open()
            closed = await ended(here)
            assert (closed.code, closed.reason) == (1006, "the other gateway is silent or has gone")
            assert (await ended(there)).code == 1006
            assert set(near.present) == {"a"}
            await until_present(far)
            with pytest.raises(DialFailed):
                await far.dial("a", {})
            relay.mend()
            await until_present(near, "a", "b")
            one, other = await pair_when_back(pair)
            await one.send("x")
            assert await other.receive() == "x"

    async def test_a_bad_way_changes_nothing_in_what_arrives(self, shared_nats: NatsServer) -> None:
        weather = Weather(delay=0.02, jitter=0.02, chop=700)
        texts = [str(number) * (number * 7 % 400) for number in range(300)] + ["x" * 200_000]
        async with (
            FaultRelay(shared_nats.url, seed=3, weather=weather) as relay,
            links(shared_nats.url, relay.url) as (near, far),
            dialled(near, far) as pair,
        ):
            here, there = await pair()
            sending = asyncio.ensure_future(here.send_many(texts))
            assert [await there.receive() for _ in texts] == texts
            await sending

    async def test_signs_of_life_pass_long_messages_on_a_way_of_16_Mbit_a_second(  # noqa: N802
        self, shared_nats: NatsServer
    ) -> None:
        text = "x" * 2_000_000
        async with (
            FaultRelay(shared_nats.url, weather=Weather(rate=2_000_000)) as relay,
            links(shared_nats.url, relay.url) as (near, far),
            dialled(near, far) as pair,
        ):
            for sender, receiver in ((ends := await pair()), ends[::-1]):
                sending = asyncio.ensure_future(sender.send(text))
                assert await receiver.receive() == text
                await sending

    async def test_what_is_no_NATS_server_is_left(self, shared_nats: NatsServer) -> None:  # noqa: N802
        async def talk(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"220 mail.example ESMTP\r\n")

        async with stand_in(talk) as place, links(f"nats://{place}") as (near,):
            assert "expecting INFO" in near.trouble


class TestProcesses:
    """The other gateway is a process of its own."""

    async def test_messages_there_and_back(self, shared_nats: NatsServer) -> None:
        prefix = cluster_name()
        async with (
            gateway_process(shared_nats.url, prefix, "b"),
            links(shared_nats.url, prefix=prefix) as (near,),
        ):
            await until_present(near, "a", "b")
            stream = await near.dial("b", {})
            for text in ("a", "日本", "x" * 3_000_000):
                await stream.send(text)
                assert await stream.receive() == text

    async def test_a_stream_is_lost_when_the_other_gateway_is_killed(self, shared_nats: NatsServer) -> None:
        prefix = cluster_name()
        async with links(shared_nats.url, prefix=prefix) as (near,):
            async with gateway_process(shared_nats.url, prefix, "b") as process:
                await until_present(near, "a", "b")
                stream = await near.dial("b", {})
                process.kill()
                closed = await ended(stream)
                assert (closed.code, closed.reason) == (1006, "the other gateway is silent or has gone")
                assert set(near.present) == {"a"}
            async with gateway_process(shared_nats.url, prefix, "b"):
                again = await back(near, "b")
                await again.send("x")
                assert await again.receive() == "x"

    async def test_a_gateway_that_stood_still_for_3_s_does_nothing_of_what_it_was_sent_meanwhile(
        self, shared_nats: NatsServer
    ) -> None:
        prefix = cluster_name()
        async with (
            gateway_process(shared_nats.url, prefix, "b") as process,
            links(shared_nats.url, prefix=prefix) as (near,),
        ):
            assert process.stdout is not None
            await until_present(near, "a", "b")
            stream = await near.dial("b", {})
            await stream.send("before")
            assert await stream.receive() == "before"
            freeze(process.pid)
            frozen = asyncio.get_running_loop().time()
            await stream.send("old")
            assert (await ended(stream)).code == 1006
            with pytest.raises(DialFailed, match="does not answer"):
                await near.dial("b", {})
            loop = asyncio.get_running_loop()
            over = loop.create_future()
            loop.call_at(frozen + 3, over.set_result, None)
            await over
            process.send_signal(signal.SIGCONT)
            assert [await process.stdout.readline() for _ in range(2)] == [b"before\n", b"ended 1006\n"]
            again = await back(near, "b")
            await again.send("new")
            assert await again.receive() == "new"
            assert await process.stdout.readline() == b"new\n"
