"""Whether the installed aiortc and aioice still are as this folder takes them to be."""

from importlib.metadata import version
from typing import Final

from aiortc import RTCConfiguration, RTCPeerConnection
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtp import RtcpRrPacket

from openrois_streaming.aiortc_internals import channels, ice_rehearsal, incoming, receiving, sending
from openrois_streaming.aiortc_internals.code import names_in
from openrois_streaming.aiortc_internals.connection import negotiated_codec
from openrois_streaming.aiortc_internals.incoming import Incoming
from openrois_streaming.network.guard import GuardFigures

TESTED: Final = {"aiortc": "1.16.", "aioice": "0.13."}
"""The versions that the tests of this package ran with."""


class UnsupportedLibrary(RuntimeError):
    """An installed aiortc or aioice is not one that this package was made for. The text says what differs."""


async def self_test() -> None:
    """Try on a peer connection of its own all that this folder relies on; opens no socket.

    Raises:
        UnsupportedLibrary: something is not as it was in the tested versions.
    """
    for name, tested in TESTED.items():
        if not version(name).startswith(tested):
            raise UnsupportedLibrary(f"{name} {version(name)} is installed; tested are {tested}*")
    connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
    try:
        wrong = await _differences(connection)
    except (AttributeError, TypeError) as error:
        wrong = [str(error)]
    finally:
        await connection.close()
    if wrong:
        raise UnsupportedLibrary("; ".join(wrong))


async def _differences(connection: RTCPeerConnection) -> list[str]:
    transceiver = connection.addTransceiver("video", direction="sendonly")
    dtls = transceiver.sender.transport
    seen: list[object] = []
    Incoming(dtls, lambda: seen.append("rtcp"), GuardFigures())
    await dtls._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1, reports=[])))
    await connection.createOffer()
    checks = {
        "sections are started elsewhere": all(
            "_RTCPeerConnection__connect" in names_in(described)
            for described in (RTCPeerConnection.setLocalDescription, RTCPeerConnection.setRemoteDescription)
        ),
        "reports do not arrive": seen == ["rtcp"],
        "the negotiated codec is elsewhere": negotiated_codec(transceiver) is not None,
    }
    wrong = [difference for difference, holds in checks.items() if not holds]
    sent = await sending.differences(connection)
    received = await receiving.differences(connection.addTransceiver("video", direction="recvonly"))
    data = channels.differences(connection.createDataChannel("trial", negotiated=True, id=0).transport)
    return wrong + data + incoming.differences() + sent + received + await ice_rehearsal.differences()
