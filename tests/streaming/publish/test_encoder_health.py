from openrois_streaming.publish.encoder_health import AVOIDED_FOR, FAILURES, GIVEN_UP_AFTER, EncoderHealth

H264, VP8 = "video/H264", "video/VP8"


def fails(health: EncoderHealth, since: float, until: float) -> bool:
    """Have H.264 fail at these moments and evenly between, and return whether it is usable after that."""
    usable = True
    for number in range(FAILURES):
        usable = health.is_usable(H264, MemoryError(), since + (until - since) * number / (FAILURES - 1))
    return usable


def test_a_codec_is_usable_until_its_encoders_have_failed_several_times_for_a_while() -> None:
    health = EncoderHealth()
    assert fails(health, 10.0, 10.0 + GIVEN_UP_AFTER - 0.1)
    assert not health.is_usable(H264, MemoryError(), 10.0 + GIVEN_UP_AFTER)
    assert health.is_usable(VP8, None, 10.0 + GIVEN_UP_AFTER)


def test_single_failure_does_not_avoid_the_codec() -> None:
    health, failure = EncoderHealth(), MemoryError()
    assert all(health.is_usable(H264, failure, seconds / 8) for seconds in range(800))


def test_a_frame_in_between_begins_the_count_anew() -> None:
    health = EncoderHealth()
    assert fails(health, 0.0, GIVEN_UP_AFTER - 0.1)
    assert health.is_usable(H264, None, GIVEN_UP_AFTER - 0.05)
    assert fails(health, GIVEN_UP_AFTER, 2 * GIVEN_UP_AFTER - 0.1)
    assert not health.is_usable(H264, MemoryError(), 2 * GIVEN_UP_AFTER)


def test_avoided_codec_is_tried_again_later() -> None:
    health = EncoderHealth()
    assert not fails(health, 0.0, GIVEN_UP_AFTER)
    assert not health.is_usable(H264, None, GIVEN_UP_AFTER + AVOIDED_FOR - 0.1)
    assert health.is_usable(H264, None, GIVEN_UP_AFTER + AVOIDED_FOR)
