"""Self-test: the installed aiortc and aioice are as this folder relies on."""

from importlib.metadata import version
from typing import Final

from aiortc import RTCConfiguration, RTCPeerConnection
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtp import RtcpRrPacket

from openrois_streaming.aiortc_internals import channels, ice_rehearsal, incoming, names_in, receiving, sending
from openrois_streaming.aiortc_internals.connection import negotiated_codec
from openrois_streaming.aiortc_internals.incoming import Incoming
from openrois_streaming.network.guard import GuardFigures

TESTED: Final = {"aiortc": "1.16.", "aioice": "0.13."}
"""Versions that the tests of this package ran with."""


class UnsupportedLibrary(RuntimeError):
    """Installed aiortc or aioice that this package does not support. The text says what differs."""


async def self_test() -> None:
    """Try everything that this folder relies on, on a peer connection of its own; opens no socket.

    Raises:
        UnsupportedLibrary: something differs from the tested versions.
    """
    for name, tested in TESTED.items():
        if not version(name).startswith(tested):
            raise UnsupportedLibrary(f"{name} {version(name)} is installed and not tested: install {name}=={tested}*")
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
