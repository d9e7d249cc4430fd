"""The viewers: peer connections of aiortc that answer offers, and drop RTP as it arrives. Counts what came.

All of them accept one SRTP profile alone, so that every sender encrypts alike. Run by `__main__`.
"""

import asyncio
import json
import sys
from typing import Any

import aioice.ice
import aiortc.rtcdtlstransport
import uvloop
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy

PROFILE = b"SRTP_AES128_CM_SHA1_80"
"""RFC 3711's own, which all peers have."""

_LINE_LIMIT = 1 << 20
# aiortc tells fingerprints of three kinds, and Janus takes only this one.
_FINGERPRINTS = ("a=fingerprint:sha-384", "a=fingerprint:sha-512")


class Counter:
    """Counts of the packets of all viewers."""

    def __init__(self) -> None:
        self.packets = self.octets = 0

    def take_over(self) -> None:
        """Stand before aioice: RTP is counted and dropped, everything else goes on."""
        received = aioice.ice.StunProtocol.datagram_received

        def count(protocol: aioice.ice.StunProtocol, data: Any, addr: Any) -> None:
            # RFC 7983 section 7, and RFC 5761 section 4 for RTCP.
            if 128 <= data[0] < 192 and not 192 <= data[1] <= 223:
                self.packets += 1
                self.octets += len(data)
            else:
                received(protocol, data, addr)

        aioice.ice.StunProtocol.datagram_received = count  # type: ignore[method-assign,assignment]


async def serve() -> None:
    """Answer what is asked, until the input ends."""
    counter = Counter()
    counter.take_over()
    profiles = aiortc.rtcdtlstransport.SRTP_PROFILES
    profiles[:] = [each for each in profiles if each.openssl_profile == PROFILE]
    assert profiles, "aiortc has no such profile"
    reader = asyncio.StreamReader(limit=_LINE_LIMIT)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    connections: list[RTCPeerConnection] = []
    while line := await reader.readline():
        asked = json.loads(line)
        if "sdp" in asked:
            connections.append(connection := RTCPeerConnection(_CONFIGURATION))
            print(json.dumps({"sdp": await _make_answer(connection, asked["sdp"])}), flush=True)
        else:
            connected = sum(each.connectionState == "connected" for each in connections)
            print(
                json.dumps({"packets": counter.packets, "octets": counter.octets, "connected": connected}), flush=True
            )
    await asyncio.gather(*(connection.close() for connection in connections))


_CONFIGURATION = RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)


async def _make_answer(connection: RTCPeerConnection, sdp: str) -> str:
    await connection.setRemoteDescription(RTCSessionDescription(sdp, "offer"))
    await connection.setLocalDescription(await connection.createAnswer())
    answer: str = connection.localDescription.sdp
    return "".join(line for line in answer.splitlines(keepends=True) if not line.startswith(_FINGERPRINTS))


if __name__ == "__main__":
    uvloop.run(serve())
