"""Self-test of the guard: an ICE session is rehearsed without any socket."""

import asyncio
from typing import Any, Final

from aioice import stun
from aiortc.rtcicetransport import RTCIceGatherer, RTCIceTransport

from openrois_streaming.aiortc_internals.ice import GuardedProtocol, IceAgent, local_candidate
from openrois_streaming.network.guard import REPLIES_AT_ONCE, GuardFigures, Source
from openrois_streaming.network.turns import Ingress

_PEER: Final = ("192.0.2.1", 5000)
_MOVED: Final = ("192.0.2.1", 5001)
_STRANGER: Final = ("192.0.2.2", 5000)
_NAME, _PASSWORD = "there", "p" * 22
_HELLO: Final = b"\x16\xfe\xff" + bytes(40)
_TIMEOUT: Final = 5.0


class _Wire(asyncio.DatagramTransport):
    """Other end of a socket: a peer that answers connectivity checks at the addresses of `listens`."""

    def __init__(self) -> None:
        super().__init__()
        self.protocol: GuardedProtocol
        self.listens = {_PEER}
        self.replies = 0

    def sendto(self, data: Any, addr: Any = None) -> None:
        message = stun.parse_message(bytes(data))
        if message.message_class is not stun.Class.REQUEST:
            self.replies += 1
        elif addr in self.listens:
            answer = stun.Message(message.message_method, stun.Class.RESPONSE, message.transaction_id)
            answer.attributes["XOR-MAPPED-ADDRESS"] = ("192.0.2.9", 9)
            answer.add_message_integrity(_PASSWORD.encode())
            asyncio.get_running_loop().call_soon(self.protocol.datagram_received, bytes(answer), addr)
        else:
            raise OSError("no peer listens there")  # so that no answer is awaited

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return default

    def close(self) -> None:
        self.protocol.connection_lost(None)


class Rehearsal:
    """ICE session between an agent and the wire."""

    def __init__(self) -> None:
        self.figures = GuardFigures()
        self._here = local_candidate("host", "192.0.2.9", 9, base="192.0.2.9")
        transport = RTCIceTransport(RTCIceGatherer(iceServers=[]))

        async def gather() -> list[Any]:
            return [self._here]

        self.agent = IceAgent(transport, gather, lambda host, port: True, self.figures, Ingress())
        self.wire = _Wire()
        self.protocol = self.wire.protocol = GuardedProtocol(self.agent)
        self.protocol.local_candidate = self._here
        self.protocol.connection_made(self.wire)
        self.agent.adopt(self.protocol)

    def check(self, source: Source) -> None:
        """Receive an authentic connectivity check from `source`."""
        connection = self.agent.connection
        request = stun.Message(stun.Method.BINDING, stun.Class.REQUEST)
        request.attributes |= {"USERNAME": f"{connection.local_username}:{_NAME}", "PRIORITY": 1}
        request.attributes["ICE-CONTROLLED"] = 1
        request.add_message_integrity(connection.local_password.encode())
        self.protocol.datagram_received(bytes(request), source)

    async def play(self) -> list[str]:
        """Play the session and return what was not as it should be."""
        connection = self.agent.connection
        wrong: list[str] = []

        def expect(holds: bool, otherwise: str) -> None:
            if not holds:
                wrong.append(otherwise)

        connection.ice_controlling = True
        await connection.gather_candidates()
        expect(connection.local_candidates == [self._here], "candidates are gathered elsewhere")
        self.protocol.datagram_received(_HELLO, _STRANGER)
        expect(self.agent.waiting == 0 and self.figures.strangers == 1, "datagrams of strangers are not stopped")
        self.protocol.datagram_received(
            b"\x00\x01\x00\x08\x21\x12\xa4\x42" + bytes(12) + b"\x00\x24\x00\x01    ", _PEER
        )
        expect(self.figures.malformed == 1, "malformed STUN is not contained")
        for _ in range(2 * REPLIES_AT_ONCE):
            self.protocol.datagram_received(bytes(stun.Message(stun.Method.BINDING, stun.Class.REQUEST)), _STRANGER)
        expect(0 < self.wire.replies <= REPLIES_AT_ONCE + 1, "replies to strangers are not limited")
        self.check(_PEER)
        self.protocol.datagram_received(_HELLO, _PEER)
        expect(self.agent.waiting == 0, "datagrams pass before their source has proven itself")
        connection.remote_username, connection.remote_password = _NAME, _PASSWORD
        await connection.connect()
        expect(self.agent.waiting == 1, "what came early from a peer is lost")
        expect([path[1:] for path in self.agent.paths] == [_PEER], "the path that is sent over is elsewhere")
        self.wire.listens = {_MOVED}
        self.check(_MOVED)
        await self.agent.checks.settled()
        self.protocol.datagram_received(_HELLO, _MOVED)
        expect(self.agent.waiting == 2, "a peer that has moved is not received")
        expect([path[1:] for path in self.agent.paths] == [_MOVED], "a peer that has moved is not followed")
        return wrong


async def differences() -> list[str]:
    """Return the differences of aioice from what this package relies on; empty if there are none."""
    rehearsal = Rehearsal()
    try:
        async with asyncio.timeout(_TIMEOUT):
            return await rehearsal.play()
    except (AttributeError, TypeError, KeyError, ConnectionError, TimeoutError) as error:
        return [f"the ICE rehearsal failed: {error!r}"]
    finally:
        await rehearsal.agent.connection.close()
