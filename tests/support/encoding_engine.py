"""A game engine, a process of its own, that encodes its pictures itself: `python -m tests.support.encoding_engine`.

It shows colour bars with a stamp, and tells in its log what is asked of its encoder.
"""

import time

import numpy as np
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Bitrate, Command, Hello, KeyFrame, Log, Quit, VideoShape
from openrois_streaming.codecs import H264
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import RawVideo
from openrois_streaming.source.stamp import stamped

WIDTH, HEIGHT, FPS = 320, 180, 30
HELLO = Hello("encoder", "1", VideoShape(WIDTH, HEIGHT, FPS, "h264"))


def main() -> None:
    with connect_from_environment(HELLO) as link:
        encoder = VideoEncoder(H264, bitrate=500_000, frame_rate=FPS)
        due, number, key_frame, done = time.monotonic(), 0, True, False
        while link.connected and not done:
            for command in link.poll_commands(max(0.0, due - time.monotonic())):
                key_frame, done = key_frame or isinstance(command, KeyFrame), done or isinstance(command, Quit)
                obey(link, encoder, command)
            if time.monotonic() < due:
                continue
            # What a busy machine was too late for is left out, as a game does.
            due = max(due + 1 / FPS, time.monotonic())
            key_frame = not show(link, encoder, picture(number), key_frame)
            number += 1


def obey(link: LinkClient, encoder: VideoEncoder, command: Command) -> None:
    if isinstance(command, KeyFrame):
        link.send_event(Log("key frame"))
    if isinstance(command, Bitrate):
        encoder.set_bitrate(command.bits_per_second)
        link.send_event(Log(f"bitrate {command.bits_per_second}"))


def picture(number: int) -> RawVideo:
    now = time.monotonic()
    data = np.full((HEIGHT * 3 // 2, WIDTH), 128, np.uint8)
    data[:HEIGHT] = 16 + (np.arange(WIDTH) + 4 * number) % 220
    return stamped(RawVideo(data, "i420", WIDTH, HEIGHT, number, now), time.time())


def show(link: LinkClient, encoder: VideoEncoder, raw: RawVideo, key_frame: bool) -> bool:
    """Send a picture; False says that the next one has to be a key frame."""
    (chunk,) = encoder.encode(raw, key_frame=key_frame)
    moment = round(raw.captured_at * 1e9)
    return link.send_encoded(chunk.data, WIDTH, HEIGHT, moment, keyframe=chunk.keyframe)


if __name__ == "__main__":
    main()
