"""Streams between gateways over a real NATS server that does nothing wrong."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from typing import Any

import pytest

from openrois.cluster import exchange
from openrois.cluster.dial_failed import DialFailed
from openrois.cluster.flow import MESSAGE_COST, WINDOW
from openrois.cluster.frames import CUT_FRAME, Address, Dial, Kind, pack_frame, pack_grant, pack_texts, parse_close
from openrois.cluster.link import NatsLink, NatsStream
from openrois.jsonrpc.session import RpcSession
from openrois.transport.stream import BatchStream, StreamClosed
from tests.support.nats import NatsServer, Stranger, cluster_name, dialled, echo, ended, links, patient_links, settings

pytestmark = pytest.mark.extra(name="cluster")


Strange = tuple[NatsLink, Stranger]


@pytest.fixture
async def strange(shared_nats: NatsServer) -> AsyncIterator[Strange]:
    """A gateway, and a program in its cluster that is none."""
    prefix = cluster_name()
    async with (
        links(shared_nats.url, prefix=prefix) as (near,),
        Stranger.entered(shared_nats.url, prefix) as stranger,
    ):
        yield near, stranger


class TestDialling:
    async def test_a_gateway_gets_the_stream_with_what_is_asserted(self, shared_nats: NatsServer) -> None:
        came: asyncio.Queue[tuple[NatsStream, Mapping[str, Any]]] = asyncio.Queue()

        async def handle(stream: NatsStream, hello: Mapping[str, Any]) -> None:
            await came.put((stream, hello))
            await stream.send("welcome")

        async with links(shared_nats.url, shared_nats.url) as (near, far):
            await far.listen(handle)
            stream = await near.dial("b", {"subject": "alice", "roles": ["operator"]})
            there, hello = await came.get()
            assert isinstance(stream, BatchStream)
            assert (there.gateway_id, stream.gateway_id) == ("a", "b")
            assert hello == there.hello == {"subject": "alice", "roles": ["operator"]}
            assert await stream.receive() == "welcome"
            # The handler has returned.
            assert (await ended(stream)).code == 1000
            assert (len(near), len(far)) == (0, 0)

    @pytest.mark.parametrize("gateway_id", ["a.b", "*", ">", "eins zwei\r\n", "日本", "_2a"])
    async def test_ids_are_any_text(self, shared_nats: NatsServer, gateway_id: str) -> None:
        prefix = cluster_name()
        async with (
            NatsLink(settings(shared_nats.url, prefix), gateway_id) as near,
            NatsLink(settings(shared_nats.url, prefix), "x") as other,
        ):
            await near.listen(echo)
            stream = await other.dial(gateway_id, {})
            await stream.send("a")
            assert await stream.receive() == "a"
            with pytest.raises(DialFailed, match="no gateway of that id listens"):
                await other.dial(gateway_id + "x", {})

    async def test_clusters_of_other_names_do_not_meet(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url) as (one,), links(shared_nats.url, shared_nats.url) as (_, other):
            await other.listen(echo)
            with pytest.raises(DialFailed):
                await one.dial("b", {})

    async def test_a_refusal_carries_code_and_reason(self, shared_nats: NatsServer) -> None:
        async def refuse(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
            await stream.close(4009, "another gateway owns it")

        async with links(shared_nats.url, shared_nats.url) as (near, far):
            await far.listen(refuse)
            with pytest.raises(DialFailed) as raised:
                await near.dial("b", {})
            assert (raised.value.code, raised.value.reason) == (4009, "another gateway owns it")
            assert str(raised.value) == "gateway 'b' refuses with 4009: another gateway owns it"
            assert (len(near), len(far)) == (0, 0)

    async def test_a_gateway_that_does_not_listen_is_said(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url, shared_nats.url) as (near, _far):
            with pytest.raises(DialFailed) as raised:
                await near.dial("b", {})
            assert raised.value.code == 1006
            assert str(raised.value) == "gateway 'b' is not reached: no gateway of that id listens"

    async def test_a_gateway_that_does_not_decide_is_left(
        self, shared_nats: NatsServer, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        came: asyncio.Queue[NatsStream] = asyncio.Queue()

        async def ponder(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
            await came.put(stream)
            await asyncio.Event().wait()

        monkeypatch.setattr(exchange, "DIAL_TIMEOUT", 0.05)
        async with links(shared_nats.url, shared_nats.url) as (near, far):
            await far.listen(ponder)
            with pytest.raises(DialFailed, match=r"it does not answer within 0\.05 s"):
                await near.dial("b", {})
            # It accepts too late: the gateway that dialled has no such stream any more.
            late = await came.get()
            late.accept()
            assert (await ended(late)).code == 1006
            assert (len(near), len(far)) == (0, 0)

    async def test_a_dial_that_is_cancelled_leaves_nothing(self, shared_nats: NatsServer) -> None:
        async def ponder(_stream: NatsStream, _hello: Mapping[str, Any]) -> None:
            await asyncio.Event().wait()

        async with links(shared_nats.url, shared_nats.url) as (near, far):
            await far.listen(ponder)
            dialling = asyncio.ensure_future(near.dial("b", {}))
            await asyncio.wait({dialling}, timeout=0.05)
            dialling.cancel()
            await asyncio.wait({dialling})
            assert len(near) == 0

    async def test_no_more_streams_than_there_may_be(self, shared_nats: NatsServer) -> None:
        prefix = cluster_name()
        async with (
            NatsLink(settings(shared_nats.url, prefix), "a", max_streams=3) as near,
            NatsLink(settings(shared_nats.url, prefix), "b", max_streams=2) as far,
        ):
            await far.listen(echo)
            streams = [await near.dial("b", {}) for _ in range(2)]
            with pytest.raises(DialFailed, match="refuses with 1013: this gateway has 2 streams already"):
                await near.dial("b", {})
            await near.listen(echo)
            with pytest.raises(DialFailed, match="is not reached: this gateway has 2 streams already"):
                await far.dial("a", {})
            await streams[0].close()
            await ended(streams[0])
            assert (await near.dial("b", {})).closed is None

    async def test_an_id_and_what_is_asserted_have_bounds(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url) as (near,):
            with pytest.raises(ValueError, match="1 to 128 bytes"):
                await near.dial("", {})
            with pytest.raises(ValueError, match="what is asserted is too long"):
                await near.dial("b", {"x": "x" * 40_000})
            assert len(near) == 0

    async def test_a_handler_that_fails_ends_its_stream_alone(
        self, shared_nats: NatsServer, caplog: pytest.LogCaptureFixture
    ) -> None:
        async def fail(stream: NatsStream, hello: Mapping[str, Any]) -> None:
            stream.accept()
            if hello:
                raise ZeroDivisionError
            await echo(stream, hello)

        async with links(shared_nats.url, shared_nats.url) as (near, far):
            await far.listen(fail)
            good, bad = await near.dial("b", {}), await near.dial("b", {"fail": True})
            assert (await ended(bad)).code == 1011
            await good.send("a")
            assert await good.receive() == "a"
        assert "a task failed" in caplog.text

    async def test_one_handler_listens(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url) as (near,):
            await near.listen(echo)
            with pytest.raises(RuntimeError, match="one handles all streams"):
                await near.listen(echo)
            own = await near.dial("a", {})
            await own.send("to itself")
            assert await own.receive() == "to itself"

    async def test_a_link_that_is_left_says_goodbye(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url) as (near,):
            pass
        with pytest.raises(DialFailed, match="the link was left"):
            await near.dial("b", {})
        prefix = cluster_name()
        async with NatsLink(settings(shared_nats.url, prefix), "a") as near:
            async with NatsLink(settings(shared_nats.url, prefix), "b") as far:
                await far.listen(echo)
                stream = await near.dial("b", {})
                assert set(near.present) == {"a", "b"}
            closed = await ended(stream)
            assert (closed.code, closed.reason) == (1001, "the gateway is leaving")
            assert set(near.present) == {"a"}


class TestMessages:
    async def test_a_message_of_20_million_characters(self, shared_nats: NatsServer) -> None:
        text = "日" * 1000 + "x" * 20_000_000
        async with links(shared_nats.url, shared_nats.url) as (near, far), dialled(near, far) as pair:
            here, there = await pair()
            sending = asyncio.ensure_future(here.send(text))
            assert await there.receive() == text
            await sending

    async def test_a_message_that_is_too_long_ends_the_stream_and_says_so(self, shared_nats: NatsServer) -> None:
        async with (
            links(shared_nats.url, shared_nats.url, max_message=100_000) as (near, far),
            dialled(near, far) as pair,
        ):
            here, there = await pair()
            await here.send("x" * 100_000)
            assert len(await there.receive()) == 100_000
            await here.send("x" * 100_001)
            for end in (here, there):
                closed = await ended(end)
                assert (closed.code, closed.reason) == (1009, "a message has at most 100000 bytes")

    @pytest.mark.parametrize("size", [0, 350, 100_000, 3_000_000])
    async def test_a_receiver_that_never_reads_holds_a_window_and_its_sender_waits(
        self, shared_nats: NatsServer, size: int
    ) -> None:
        async with links(shared_nats.url, shared_nats.url) as (near, far), dialled(near, far) as pair:
            here, there = await pair()
            sent: list[int] = []
            sending = asyncio.ensure_future(fill(here, "x" * size, sent))
            before = -1
            while before != len(sent):
                before = len(sent)
                await asyncio.wait({sending}, timeout=0.5)
            assert not sending.done()
            assert not here.send_now("x" * 500_000)
            assert there.held <= WINDOW + size
            assert len(sent) <= (WINDOW + size) // (MESSAGE_COST + size) + 1
            # Others are not kept waiting.
            one, other = await pair()
            await one.send("a")
            assert await other.receive() == "a"
            there.abort()
            with pytest.raises(StreamClosed):
                await sending

    async def test_200_streams_at_once(self, shared_nats: NatsServer) -> None:
        async def converse(number: int) -> list[str]:
            stream = await near.dial("b", {"number": number})
            for turn in range(10):
                await stream.send(f"{number} {turn} " + "x" * 3000)
            return [(await stream.receive()).rstrip("x") for _ in range(10)]

        with patient_links():
            async with links(shared_nats.url, shared_nats.url) as (near, far):
                await far.listen(echo)
                answers = await asyncio.gather(*(converse(number) for number in range(200)))
                assert answers == [[f"{number} {turn} " for turn in range(10)] for number in range(200)]
                assert len(far) == 200

    async def test_a_session_of_json_rpc_runs_over_it(self, shared_nats: NatsServer) -> None:
        async def double(params: Any) -> int:
            return int(params["number"]) * 2

        async with links(shared_nats.url, shared_nats.url) as (near, far), dialled(near, far) as pair:
            here, there = await pair()
            asking, serving = RpcSession(here), RpcSession(there, {"double": double})
            running = [asyncio.ensure_future(session.run()) for session in (asking, serving)]
            answers = await asyncio.gather(*(asking.call("double", {"number": number}) for number in range(500)))
            assert answers == [2 * number for number in range(500)]
            await asking.close(1000, "done")
            assert [(await each).code for each in running] == [1000, 1000]

    async def test_a_message_that_is_given_up_half_way_ends_the_stream(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url, shared_nats.url) as (near, far), dialled(near, far) as pair:
            here, there = await pair()
            await here.send("before")
            sending = asyncio.ensure_future(here.send("x" * 10_000_000))
            await there.receive()
            # It waits for credit, as a message before it is not received.
            await asyncio.wait({sending}, timeout=0)
            sending.cancel()
            await asyncio.wait({sending})
            for end in (here, there):
                assert (await ended(end)).code == 1006

    async def test_what_waits_was_not_sent_at_once(self, shared_nats: NatsServer) -> None:
        async with links(shared_nats.url, shared_nats.url) as (near, far), dialled(near, far) as pair:
            here, there = await pair()
            sending = asyncio.ensure_future(here.send("x" * 3_000_000))
            await asyncio.sleep(0)
            assert not here.send_now("too early")
            assert len(await there.receive()) == 3_000_000
            await sending
            assert here.send_now("a")
            assert not here.send_now("x" * 600_000)
            assert await there.receive() == "a"


async def fill(stream: NatsStream, text: str, sent: list[int]) -> None:
    while True:
        await stream.send(text)
        sent.append(len(text))


class TestStrangers:
    """Frames that no gateway of ours sends."""

    @pytest.mark.parametrize(
        "frames",
        [
            [pack_frame(Kind.TEXT, 1, b"gap")],
            [pack_frame(Kind.TEXT, 0, b"a"), pack_frame(Kind.TEXT, 0, b"a")],
            [pack_frame(Kind.TEXT, 0, b"a"), pack_frame(Kind.TEXT, 2, b"c"), pack_frame(Kind.TEXT, 1, b"b")],
            [pack_frame(Kind.ALIVE, 5)],
            [b"\x2a" + b"\0" * 8],
            [b""],
            [b"short"],
            [pack_frame(Kind.LAST, 0, b"x")],
            [pack_frame(Kind.TEXTS, 0, pack_texts([b"x"])[:-1])],
            [pack_frame(Kind.CREDIT, 0, b"x")],
            [pack_frame(Kind.CREDIT, 0, pack_grant(0))],
            [pack_frame(Kind.CLOSE, 0)],
            [pack_frame(Kind.ACCEPT, 0, b"{}")],
            [pack_frame(Kind.ACCEPT, 0, b'{"link": "0123456789abcdef", "stream": 0, "window": 65536}')],
            [pack_frame(Kind.PART, number, b"x" * 500_000) for number in range(2)] + [pack_frame(Kind.TEXT, 2, b"x")],
            [pack_frame(Kind.TEXT, number, b"x" * 500_000) for number in range(4)],
        ],
    )
    async def test_a_stream_is_lost_on_both_sides_when_something_wrong_comes(
        self, strange: Strange, frames: list[bytes]
    ) -> None:
        near, stranger = strange
        came: asyncio.Queue[NatsStream] = asyncio.Queue()

        async def hold(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
            stream.accept()
            await came.put(stream)
            await asyncio.Event().wait()

        await near.listen(hold)
        stranger.dial("a")
        subject, stream = await stranger.accepted(), await came.get()
        for frame in frames:
            stranger.say(subject, frame)
        while (kind := (await stranger.frame()).kind) is Kind.CREDIT:
            pass
        assert kind is Kind.CUT
        closed = await ended(stream)
        assert closed.code == 1006
        assert closed.reason
        assert len(near) == 0
        assert near.gaps == closed.reason.startswith("frame ")

    async def test_what_is_no_text_ends_with_its_code(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a")
        subject = await stranger.accepted()
        stranger.say(subject, pack_frame(Kind.TEXT, 0, b"\xff"))
        frame = await stranger.frame()
        assert (frame.kind, parse_close(frame.body)) == (Kind.CLOSE, (1007, "text messages only"))

    async def test_a_gateway_that_leaves_accepts_no_stream(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        assert near._exchange is not None
        await near._exchange.close()
        stranger.dial("a")
        frame = await stranger.frame()
        assert parse_close(frame.body) == (1001, "the gateway is leaving")

    async def test_another_version_is_refused_by_name(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a", version=2)
        frame = await stranger.frame()
        code, reason = parse_close(frame.body)
        assert (frame.kind, frame.number, code) == (Kind.CLOSE, 0, 1002)
        assert reason == "streams of version 2 are not spoken here, but 1"

    async def test_what_is_no_dial_is_dropped_and_noted(
        self, strange: Strange, caplog: pytest.LogCaptureFixture
    ) -> None:
        near, stranger = strange
        await near.listen(echo)
        for data in (b"", b"{}", b"\xff" * 100):
            stranger.say(f"{stranger.prefix}.dial.a", data)
            stranger.say(f"{stranger.prefix}.beat.a", data)
        stranger.dial("a", link="*")
        stranger.dial("a")
        await stranger.accepted()
        assert caplog.text.count("a gateway that dials is not understood") == 4
        assert caplog.text.count("a gateway is not understood") == 3

    async def test_an_end_whose_other_end_is_not_there_learns_that(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a")
        subject = await stranger.accepted()
        missing = subject.rpartition(".")[0]
        address = Address(link=Stranger.LINK, stream=0).model_dump_json().encode()
        for number in ("77", "x", "-1"):
            stranger.say(f"{missing}.{number}", pack_frame(Kind.TEXT, 0, b"x"))
            stranger.say(f"{missing}.{number}", pack_frame(Kind.ALIVE, 1, address))
            assert (await stranger.frame()).kind is Kind.CUT
        assert len(near) == 1

    async def test_a_stream_shows_behind_its_last_message_how_much_it_sent(self, strange: Strange) -> None:
        near, stranger = strange

        async def greet(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
            await stream.send("a")
            await asyncio.Event().wait()

        await near.listen(greet)
        stranger.dial("a")
        await stranger.accepted()
        assert (await stranger.frame()).kind is Kind.TEXT
        alive = await asyncio.wait_for(stranger.came.get(), 30)
        assert alive == pack_frame(Kind.ALIVE, 2, alive[9:])

    async def test_an_idle_stream_shows_now_and_then_that_it_is_there(
        self, strange: Strange, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(exchange, "MARK_INTERVAL", 0.0)
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a")
        await stranger.accepted()
        for number in (1, 2):
            alive = await asyncio.wait_for(stranger.came.get(), 30)
            assert alive == pack_frame(Kind.ALIVE, number, alive[9:])

    async def test_a_cut_ends_a_stream(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a")
        stranger.say(await stranger.accepted(), CUT_FRAME)
        stranger.dial("a", stream=1)
        await stranger.accepted()
        assert len(near) == 1

    async def test_a_gateway_that_never_gives_a_sign_of_life_is_silent(self, strange: Strange) -> None:
        near, stranger = strange
        await near.listen(echo)
        stranger.dial("a")
        await stranger.accepted()
        assert (await stranger.frame()).kind is Kind.CUT
        assert Dial.model_fields["version"].default == 1
