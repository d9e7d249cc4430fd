import pytest
from aiortc.rtcrtpparameters import RTCRtpHeaderExtensionParameters, RTCRtpParameters
from aiortc.rtp import HeaderExtensions, HeaderExtensionsMap
from openrois_streaming.rtp.extensions import ABS_SEND_TIME, MID, Extensions
from openrois_streaming.rtp.ntp import ntp

MOMENT = 1_800_000_000.25


def read(block: bytes, *ids: tuple[str, int]) -> HeaderExtensions:
    known = HeaderExtensionsMap()
    known.configure(
        RTCRtpParameters(headerExtensions=[RTCRtpHeaderExtensionParameters(id=id, uri=uri) for uri, id in ids])
    )
    assert len(block) == 4 + 4 * int.from_bytes(block[2:4], "big")
    return known.get(int.from_bytes(block[:2], "big"), block[4:])


@pytest.mark.parametrize("mid", ["0", "12", "video-section"])
def test_both_are_there_until_the_receiver_knows_the_sender(mid: str) -> None:
    extensions = Extensions(1, mid, 3)
    values = read(extensions.block(MOMENT), (MID, 1), (ABS_SEND_TIME, 3))
    assert (values.mid, values.abs_send_time) == (mid, int(MOMENT % 64 * 2**18))
    extensions.acknowledged()
    values = read(extensions.block(MOMENT), (MID, 1), (ABS_SEND_TIME, 3))
    assert (values.mid, values.abs_send_time) == (None, int(MOMENT % 64 * 2**18))


def test_unnegotiated_extensions_are_left_out() -> None:
    assert read(Extensions(2, "1", None).block(MOMENT), (MID, 2)).mid == "1"
    assert read(Extensions(None, "1", 4).block(MOMENT), (ABS_SEND_TIME, 4)).abs_send_time is not None
    assert Extensions(None, "1", None).block(MOMENT) == b""
    assert Extensions(1, "", None).block(MOMENT) == b""


def test_a_name_longer_than_an_element_is_not_sent_whole() -> None:
    assert read(Extensions(1, "m" * 20, None).block(MOMENT), (MID, 1)).mid == "m" * 16


@pytest.mark.parametrize("abs_send_time_id", [3, None])
def test_playout_delay_says_whether_to_play_at_once(abs_send_time_id: int | None) -> None:
    """Two numbers of 12 bits, in units of 10 ms: at least, and at most."""
    extensions = Extensions(1, "0", abs_send_time_id, 4)
    for _ in range(2):
        assert b"\x42\x00\x00\x00" in extensions.block(MOMENT, at_once=True)
        assert b"\x42\x00\x03\xe8" in extensions.block(MOMENT, at_once=False)
        block = extensions.block(MOMENT)
        assert len(block) == 4 + 4 * int.from_bytes(block[2:4], "big") <= 20
        extensions.acknowledged()


@pytest.mark.parametrize("abs_send_time_id", [3, None])
def test_a_capture_time_stands_where_it_is_given_and_the_receiver_takes_it(abs_send_time_id: int | None) -> None:
    extensions = Extensions(1, "0", abs_send_time_id, 4, 5)
    told = b"\x57" + ntp(MOMENT - 0.25).to_bytes(8, "big")
    for known in (False, True):
        block = extensions.block(MOMENT, at_once=True, captured=MOMENT - 0.25)
        assert told in block
        assert b"\x42\x00\x00\x00" in block
        values = read(block, (MID, 1), (ABS_SEND_TIME, 3))
        assert values.mid == (None if known else "0")
        assert values.abs_send_time == (None if abs_send_time_id is None else int(MOMENT % 64 * 2**18))
        assert len(block) <= 24
        assert told[:1] not in extensions.block(MOMENT, at_once=True)[4:]
        extensions.acknowledged()
    plain = Extensions(1, "0", abs_send_time_id, 4)
    assert plain.block(MOMENT, captured=MOMENT) == plain.block(MOMENT)
