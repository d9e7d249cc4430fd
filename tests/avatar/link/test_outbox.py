import threading

from openrois_avatar.link.messages import Bye, Completed, Log
from openrois_avatar.link.outbox import MAX_AUDIO_BLOCKS, MAX_ENCODED, MAX_EVENTS, Outbox
from openrois_avatar.link.protocol import Audio, Encoded, Message, PixelFormat, Video


def picture(sequence: int) -> Video:
    return Video(sequence, 0, 2, 2, 8, PixelFormat.BGRA, bytes(16))


def block(sequence: int) -> Audio:
    return Audio(sequence, 0, 1, bytes(2))


def test_events_go_first_then_sound_then_the_picture() -> None:
    outbox = Outbox()
    outbox.put_video(picture(0))
    outbox.put_audio(block)
    outbox.put_event(Log("a"))
    outbox.put_event(Log("b"))
    assert [outbox.next_message() for _ in range(4)] == [Log("a"), Log("b"), block(0), picture(0)]


def test_newest_picture_replaces_the_waiting_one_and_the_gap_shows() -> None:
    outbox = Outbox()
    for number in range(3):
        outbox.put_video(picture(number))
    assert outbox.next_message() == picture(2)
    assert outbox.dropped_video == 2


def test_encoded_pictures_are_sent_all_and_in_order_or_not_before_a_key_frame() -> None:
    outbox = Outbox()

    def coded(sequence: int, *, keyframe: bool = False) -> Encoded:
        return Encoded(sequence, 0, 2, 2, keyframe, b"")

    assert all(outbox.put_encoded(coded(number)) for number in range(MAX_ENCODED))
    assert outbox.next_message() == coded(0)
    assert outbox.put_encoded(coded(8))
    assert not outbox.put_encoded(coded(9))
    assert not outbox.put_encoded(coded(10))
    assert outbox.put_encoded(coded(11, keyframe=True))
    assert outbox.put_encoded(coded(12))
    assert [outbox.next_message(), outbox.next_message()] == [coded(11, keyframe=True), coded(12)]
    assert outbox.dropped_video == MAX_ENCODED + 2
    outbox.put_encoded(coded(13))
    outbox.finish(Bye("end"))
    assert outbox.next_message() == Bye("end")


def test_the_socket_can_be_claimed_only_while_nothing_else_wants_it() -> None:
    outbox = Outbox()
    assert outbox.claim()
    assert not outbox.claim()
    outbox.unclaim()
    outbox.put_event(Log("first"))
    assert not outbox.claim()
    assert outbox.next_message() == Log("first")
    assert not outbox.claim()
    outbox.abort()
    assert outbox.next_message() is None
    assert not outbox.claim()


def test_the_rest_of_what_has_begun_goes_before_everything_else() -> None:
    outbox = Outbox()
    assert outbox.claim()
    outbox.put_event(Log("later"))
    outbox.unclaim(b"rest")
    assert not outbox.claim()
    outbox.finish(Bye("end"))
    assert [outbox.next_message() for _ in range(4)] == [b"rest", Log("later"), Bye("end"), None]


def test_sound_is_bounded_and_loses_its_oldest_block() -> None:
    outbox = Outbox()
    for _ in range(MAX_AUDIO_BLOCKS + 3):
        outbox.put_audio(block)
    assert outbox.next_message() == block(3)
    assert outbox.dropped_audio == 3


def test_events_are_bounded_and_never_lost_silently() -> None:
    outbox = Outbox()
    assert all(outbox.put_event(Completed(str(number), "OK")) for number in range(MAX_EVENTS))
    assert not outbox.put_event(Completed("one too many", "OK"))
    assert outbox.next_message() == Completed("0", "OK")


def test_finishing_sends_the_events_and_the_farewell() -> None:
    outbox = Outbox()
    outbox.put_video(picture(0))
    outbox.put_audio(block)
    outbox.put_event(Log("last"))
    outbox.finish(Bye("end"))
    outbox.finish(Bye("again"))
    assert [outbox.next_message() for _ in range(3)] == [Log("last"), Bye("end"), None]


def test_aborting_sends_nothing_more() -> None:
    outbox = Outbox()
    outbox.put_event(Log("lost"))
    outbox.abort()
    assert outbox.next_message() is None


def test_the_writer_wakes_for_work_and_for_the_end() -> None:
    outbox = Outbox()
    taken: list[Message | bytes] = []
    half_way = threading.Event()

    def write() -> None:
        while (message := outbox.next_message()) is not None:
            taken.append(message)
            half_way.set()

    writer = threading.Thread(target=write)
    writer.start()
    outbox.put_audio(block)
    assert half_way.wait(5)
    outbox.finish(Bye("end"))
    writer.join(5)
    assert taken == [block(0), Bye("end")]
