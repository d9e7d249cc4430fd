"""Reachability of STUN and TURN servers from this machine, and their response times."""

import asyncio
import time
from dataclasses import dataclass
from typing import cast

from aioice import stun
from aioice.turn import create_turn_endpoint

from openrois_streaming.network.servers import StunServer, TurnServer
from openrois_streaming.peer.gathering import explain

TIMEOUT = 5.0
"""Seconds that a server has to answer."""


class Unreachable(Exception):
    """Failure of a server; the text is a clause that says why."""


@dataclass(frozen=True, slots=True)
class Reached:
    """Address and port that a server gave, and its response time in seconds."""

    address: str
    port: int
    seconds: float


class _Asking(asyncio.DatagramProtocol):
    """Socket that asks one STUN server."""

    def __init__(self) -> None:
        self.transactions: dict[bytes, stun.Transaction] = {}

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        try:
            message = stun.parse_message(data)
            self.transactions[message.transaction_id].response_received(message, addr)
        except Exception:  # hostile or stray bytes are no answer
            return

    def send_stun(self, message: stun.Message, addr: tuple[str, int]) -> None:
        self._transport.sendto(bytes(message))


async def seen_by(server: StunServer) -> Reached:
    """Ask a STUN server under which address it sees this machine.

    Raises:
        Unreachable: the server does not answer.
    """
    began = time.monotonic()
    try:
        async with asyncio.timeout(TIMEOUT):
            transport, asking = await asyncio.get_running_loop().create_datagram_endpoint(
                _Asking, remote_addr=(server.host, server.port)
            )
            try:
                request = stun.Message(stun.Method.BINDING, stun.Class.REQUEST)
                transaction = stun.Transaction(request, (server.host, server.port), asking)
                asking.transactions[request.transaction_id] = transaction
                response, _ = await transaction.run()
                address, port = response.attributes["XOR-MAPPED-ADDRESS"]
            finally:
                transport.close()
    except TimeoutError:
        raise Unreachable(f"it does not answer within {TIMEOUT:.0f} s") from None
    except (OSError, stun.TransactionError, KeyError) as error:
        raise Unreachable(f"it cannot be asked ({error})") from error
    return Reached(address, port, time.monotonic() - began)


async def relayed_by(server: TurnServer) -> Reached:
    """Ask a TURN server for the address of a relay, which is released at once.

    Raises:
        Unreachable: the server does not relay.
    """
    began = time.monotonic()
    try:
        async with asyncio.timeout(TIMEOUT):
            transport, _ = await create_turn_endpoint(
                asyncio.DatagramProtocol,
                (server.host, server.port),
                server.username,
                server.credential,
                ssl=server.tls,
                transport=server.transport,
            )
    except (OSError, stun.TransactionError) as error:
        raise Unreachable(explain(error)) from error
    address, port = transport.get_extra_info("sockname")
    took = time.monotonic() - began
    transport.close()
    return Reached(address, port, took)
