import asyncio
from typing import Any

import pytest
from aiortc import RTCPeerConnection
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.turns import Ingress
from openrois_streaming.seams.ice import IceAgent

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
