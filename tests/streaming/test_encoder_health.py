from openrois_streaming.encoder_health import AVOIDED_FOR, GIVEN_UP_AFTER, EncoderHealth

H264, VP8 = "video/H264", "video/VP8"


def test_a_codec_is_usable_until_its_encoders_have_failed_for_a_while() -> None:
    health = EncoderHealth()
    assert health.is_usable(H264, is_failing=True, now=10.0)
    assert health.is_usable(H264, is_failing=True, now=10.0 + GIVEN_UP_AFTER - 0.1)
    assert not health.is_usable(H264, is_failing=True, now=10.0 + GIVEN_UP_AFTER)
    assert health.is_usable(VP8, is_failing=False, now=10.0 + GIVEN_UP_AFTER)


def test_a_frame_in_between_begins_the_count_anew() -> None:
    health = EncoderHealth()
    assert health.is_usable(H264, is_failing=True, now=0.0)
    assert health.is_usable(H264, is_failing=False, now=1.0)
    assert health.is_usable(H264, is_failing=True, now=1.5)
    assert health.is_usable(H264, is_failing=True, now=1.4 + GIVEN_UP_AFTER)
    assert not health.is_usable(H264, is_failing=True, now=1.5 + GIVEN_UP_AFTER)


def test_what_was_given_up_is_tried_again_later() -> None:
    health = EncoderHealth()
    health.is_usable(H264, is_failing=True, now=0.0)
    given_up = GIVEN_UP_AFTER
    assert not health.is_usable(H264, is_failing=True, now=given_up)
    assert not health.is_usable(H264, is_failing=False, now=given_up + AVOIDED_FOR - 0.1)
    assert health.is_usable(H264, is_failing=False, now=given_up + AVOIDED_FOR)
