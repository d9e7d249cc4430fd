from openrois_streaming.receive.limit import LEAST, MOST, START, BitrateLimit


def test_a_path_that_is_not_full_is_used_more() -> None:
    limit = BitrateLimit()
    assert limit.estimated(300_000, 10.0, full=False) == START
    assert START < limit.estimated(300_000, 10.5, full=False) < 1.05 * START
    for second in range(11, 60):
        limit.estimated(300_000, float(second), full=False)
    assert limit.bitrate == MOST


def test_a_path_that_is_full_is_used_less() -> None:
    limit = BitrateLimit()
    assert limit.estimated(400_000, 10.0, full=True) == 400_000
    assert limit.estimated(900_000, 10.1, full=True) == 400_000
    assert limit.estimated(5, 10.2, full=True) == LEAST


def test_a_pause_is_no_reason_to_rise() -> None:
    limit = BitrateLimit()
    limit.estimated(400_000, 10.0, full=True)
    assert limit.estimated(400_000, 100.0, full=False) == 432_000


def test_heavy_loss_makes_it_follow_what_arrives() -> None:
    limit = BitrateLimit()
    octets = 0
    for number in range(1, 12):
        octets += 100_000
        limit.counted(number * 150, number * 50, octets, float(number))
    assert limit.bitrate == 680_000, "a little less than arrived, so that the queue becomes shorter"


def test_random_loss_is_no_reason() -> None:
    limit = BitrateLimit()
    for number in range(1, 12):
        assert limit.counted(number * 100, number * 10, number * 100_000, float(number)) == START


def test_few_packets_say_little_and_those_of_another_source_nothing() -> None:
    limit = BitrateLimit()
    limit.counted(1000, 0, 1_000_000, 1.0)
    assert limit.counted(1030, 20, 1_010_000, 2.0) == START
    assert limit.counted(30, 20, 1_020_000, 3.0) == START
    assert limit.counted(60, 50, 1_030_000, 4.0) == START
    assert limit.counted(100, 60, 1_040_000, 5.0) < START
