import pytest
from openrois_streaming.receive.repair import Losses, RepairWindow, RoundTrip
from openrois_streaming.testing.link import Impairments

from tests.support.simulated_camera import SimulatedCamera


class TestRoundTrip:
    def test_a_request_is_repeated_when_an_answer_would_be_there(self) -> None:
        trip = RoundTrip()
        assert trip.retry == pytest.approx(0.15), "nothing is known"
        for _ in range(50):
            trip.measure(0.24)
        assert 0.25 <= trip.retry < 0.26
        for _ in range(50):
            trip.measure(0.2)
            trip.measure(0.28)
        assert 0.3 < trip.retry < 0.34, "with jitter later"

    def test_unanswered_requests_lengthen_the_retry_until_an_answer(self) -> None:
        trip = RoundTrip()
        trip.measure(0.04)
        waits = [trip.retry]
        for _ in range(4):
            trip.timed_out()
            waits.append(trip.retry)
        assert waits == pytest.approx([0.08, 0.16, 0.32, 0.32, 0.32])
        trip.measure(0.04)
        assert trip.retry < 0.08

    def test_a_local_network_is_not_asked_too_often(self) -> None:
        trip = RoundTrip()
        for _ in range(50):
            trip.measure(0.001)
        assert trip.retry == 0.02


class TestLosses:
    def test_the_answer_to_a_repeated_request_does_not_say_how_long_it_took(self) -> None:
        trip = RoundTrip()
        losses = Losses(trip)
        losses.add(range(5, 7), 1.0)
        assert losses.to_ask_for(1.0) == (5, 6)
        losses.arrived(5, 1.14)
        assert trip.seconds == pytest.approx(0.14)
        assert losses.to_ask_for(1.2) == (6,)
        losses.arrived(6, 1.21)
        assert trip.seconds == pytest.approx(0.14)
        assert losses.next_at is None

    def test_no_more_is_on_its_way_than_fits_and_the_rest_follows(self) -> None:
        losses = Losses(RoundTrip())
        losses.add(range(100), 1.0)
        assert losses.to_ask_for(1.0) == tuple(range(32))
        assert losses.to_ask_for(1.01) == ()
        assert losses.next_at == pytest.approx(1.15), "not before something comes or counts as lost"
        for sequence in range(32):
            losses.arrived(sequence, 1.05)
        assert losses.to_ask_for(1.05) == tuple(range(32, 96)), "all came: the path carries more"

    def test_when_what_is_on_its_way_is_not_waited_for_any_more_the_rest_is_asked_for(self) -> None:
        losses = Losses(RoundTrip())
        losses.add(range(40), 1.0)
        losses.to_ask_for(1.0)
        losses.forget_before(32)
        assert losses.next_at == 1.0
        assert losses.to_ask_for(1.0) == tuple(range(32, 40))


def test_the_window_is_halved_once_for_what_was_lost_together_and_grows_slowly_after_that() -> None:
    window = RepairWindow()
    for _ in range(68):
        window.came()
    assert window.packets == 100
    assert [window.failed(1.0, 1.2), window.failed(1.1, 1.3), window.failed(1.25, 1.4)] == [True, False, True]
    assert window.packets == 32
    for _ in range(32):
        window.came()
    assert 32.9 < window.packets <= 33


@pytest.mark.parametrize("seed", [1, 2])
def test_a_key_frame_larger_than_the_queue_of_a_narrow_path_comes_through_all_the_same(seed: int) -> None:
    camera = SimulatedCamera(Impairments(rate=1_000_000, delay=0.02), key_frame=60_000, seed=seed)
    camera.run(8)
    assert camera.fps(since=4) > 28
    assert camera.link.figures().dropped < 100, "most of them of the first key frame"
    assert camera.key_frames == 1


def test_random_loss_on_a_narrow_path_does_not_lead_to_key_frames_without_end() -> None:
    camera = SimulatedCamera(Impairments(rate=1_000_000, delay=0.02, loss=0.05), key_frame=20_000, seed=2)
    camera.run(15)
    assert camera.fps(since=5) > 20
    assert camera.key_frames < 10
    assert camera.assembly.duplicates < camera.repeated / 5, "what is on its way is not asked for again"
