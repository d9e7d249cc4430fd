from openrois_streaming.rtp.ntp import abs_send_time, middle, ntp


def test_times_in_their_three_forms() -> None:
    assert ntp(0.5) == 2_208_988_800 << 32 | 1 << 31
    assert middle(0x1122_3344_5566_7788) == 0x3344_5566
    assert abs_send_time(64.0 * 1000 + 1.5) == (3 << 17).to_bytes(3, "big")
