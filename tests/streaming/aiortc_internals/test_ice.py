import asyncio
import logging
from typing import Any

import pytest
from aioice import Candidate, stun
from aioice.ice import ICE_COMPLETED
from aiortc import RTCPeerConnection
from openrois_streaming.aiortc_internals.ice import IceAgent, local_candidate
from openrois_streaming.network.guard import PAIRS_LIMIT, GuardFigures
from openrois_streaming.network.interfaces import ADDRESSES_LIMIT
from openrois_streaming.network.turns import Ingress

from tests.support.streaming import settle


@pytest.mark.parametrize("given_up", [False, True])
async def test_a_socket_that_is_given_up_while_it_is_opened_is_closed(
    monkeypatch: pytest.MonkeyPatch, given_up: bool
) -> None:
    loop = asyncio.get_running_loop()
    create, made, told = loop.create_datagram_endpoint, asyncio.Event(), asyncio.Event()
    transports: list[asyncio.DatagramTransport] = []

    async def create_and_wait(*arguments: Any, **options: Any) -> Any:
        """As uvloop does it, which leaves the socket open when it is cancelled here."""
        transport, protocol = await create(*arguments, **options)
        transports.append(transport)
        made.set()
        await told.wait()
        return transport, protocol

    monkeypatch.setattr(loop, "create_datagram_endpoint", create_and_wait)
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    agent = IceAgent(
        transport, gather=NotImplemented, permits=lambda host, port: True, figures=GuardFigures(), ingress=Ingress()
    )
    opening = asyncio.ensure_future(agent.open_host("127.0.0.1", [0]))
    await made.wait()
    if given_up:
        opening.cancel()
    told.set()
    await settle()
    assert opening.cancelled() is given_up
    assert transports[0].is_closing() is given_up
    await connection.close()
    assert transports[0].is_closing()


async def test_a_check_that_is_under_way_when_its_socket_is_closed_sends_nothing_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stun, "RETRY_RTO", 0.01)
    failures: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: failures.append(context))
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    agent = IceAgent(
        transport, gather=NotImplemented, permits=lambda *_: True, figures=GuardFigures(), ingress=Ingress()
    )
    await agent.open_host("127.0.0.1", [0])
    (protocol,) = transport._connection._protocols
    asked = stun.Message(message_method=stun.Method.BINDING, message_class=stun.Class.REQUEST)
    asking = asyncio.ensure_future(protocol.request(asked, ("127.0.0.1", 9), retransmissions=1))
    await settle()
    await connection.close()
    async with asyncio.timeout(10):
        with pytest.raises(stun.TransactionTimeout):
            await asking
    assert failures == []


async def test_sockets_are_closed_by_a_process_that_stands_still_meanwhile(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    agent = IceAgent(
        transport, gather=NotImplemented, permits=lambda *_: True, figures=GuardFigures(), ingress=Ingress()
    )
    for host in range(1, 4):
        await agent.open_host(f"127.0.0.{host}", [0])
    sockets = [protocol.transport for protocol in agent.connection._protocols]
    # As where it was stopped for longer than that: the time is over before it can learn that a socket is closed.
    monkeypatch.setattr("openrois_streaming.aiortc_internals.ice.RELEASE_TIMEOUT", 0.0)
    with caplog.at_level(logging.INFO):
        await connection.close()
    assert [each.is_closing() for each in sockets] == [True] * 3
    assert "TURN" not in caplog.text


async def test_a_connection_that_is_closed_as_its_path_is_found_asks_for_no_consent() -> None:
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    agent = IceAgent(
        transport, gather=NotImplemented, permits=lambda *_: True, figures=GuardFigures(), ingress=Ingress()
    )
    ice = agent.connection
    candidate = await agent.open_host("127.0.0.1", [0])
    agent.add(candidate)
    ice._local_candidates_end = True
    ice.remote_username, ice.remote_password = "there", "p" * 22
    ice._remote_candidates.append(Candidate("0", 1, "udp", 1, "127.0.0.1", 9, "host"))
    before = asyncio.all_tasks()
    connecting = asyncio.ensure_future(ice.connect())
    async with asyncio.timeout(60):
        while not ice._check_list:  # noqa: ASYNC110 - no event tells it
            await asyncio.sleep(0)
        # The path is found: before what waits for it runs again, the connection is closed.
        ice._check_list_done = True
        ice._check_list_state.put_nowait(ICE_COMPLETED)
        await ice.close()
        with pytest.raises(ConnectionError):
            await connecting
    await connection.close()
    assert asyncio.all_tasks() == before


async def test_a_peer_connection_checks_so_many_pairs_and_the_best_of_them(caplog: pytest.LogCaptureFixture) -> None:
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    figures = GuardFigures()
    agent = IceAgent(transport, gather=NotImplemented, permits=lambda *_: True, figures=figures, ingress=Ingress())
    for host in range(1, ADDRESSES_LIMIT + 1):
        await agent.open_host(f"127.0.0.{host}", [0])
    ice = agent.connection
    with caplog.at_level(logging.INFO):
        for number in range(60):
            await ice.add_remote_candidate(
                Candidate(str(number), 1, "udp", number + 1, "127.0.0.1", 2000 + number, "host")
            )
            assert len(ice._check_list) <= PAIRS_LIMIT
    kept = {pair.remote_candidate.priority for pair in ice._check_list}
    assert kept == set(range(60 - PAIRS_LIMIT // ADDRESSES_LIMIT + 1, 61)), "those of the lowest priority are left out"
    assert [each for each in caplog.messages if "pairs" in each] == [
        "a peer connection has more than 100 candidate pairs: those of the lowest priority are not checked (RFC 8445)"
    ]
    await connection.close()


async def test_a_check_from_elsewhere_finds_room_only_as_long_as_there_is_some() -> None:
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video").sender.transport.transport
    figures = GuardFigures()
    agent = IceAgent(transport, gather=NotImplemented, permits=lambda *_: True, figures=figures, ingress=Ingress())
    await agent.open_host("127.0.0.1", [0])
    ice = agent.connection
    ice.remote_username, ice.remote_password = "there", "p" * 22
    (protocol,) = ice._protocols
    request = stun.Message(stun.Method.BINDING, stun.Class.REQUEST, attributes={"PRIORITY": 1})
    for port in range(PAIRS_LIMIT):
        await ice.add_remote_candidate(local_candidate("host", "127.0.0.1", 2000 + port, base="127.0.0.1"))
    ice.check_incoming(request, ("127.0.0.1", 3000), protocol)
    assert len(ice._check_list) == PAIRS_LIMIT
    assert [pair.remote_addr[1] for pair in ice._check_list if pair.task is not None] == [3000], (
        "it took another's place"
    )
    for pair in ice._check_list:
        ice.check_start_task(pair)
    ice.check_incoming(request, ("127.0.0.1", 3001), protocol)
    assert len(ice._check_list) == PAIRS_LIMIT
    assert figures.forbidden == 1
    await connection.close()
