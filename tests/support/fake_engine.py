"""A game engine, a process of its own that behaves as its argument says: `python -m tests.support.fake_engine good`."""

import os
import signal
import sys
import threading
import time
from dataclasses import replace

import numpy as np
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Completed, Log, Pause, Quit, React, Speak
from openrois_avatar.link.protocol import PixelFormat

from tests.support.avatar_link import HELLO


def main(behaviour: str = "good") -> None:
    if behaviour == "broken":
        print("first line")
        raise SystemExit("no graphics pipe is available")
    if behaviour == "mute":
        print("thinking", flush=True)
        threading.Event().wait()
    if behaviour == "stubborn":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    with connect_from_environment(replace(HELLO, version=str(os.getpid()))) as link:
        print("running", flush=True)
        render(link, stubborn=behaviour == "stubborn")


def render(link: LinkClient, *, stubborn: bool) -> None:
    paused = False
    while link.connected or stubborn:
        for command in link.poll_commands(0.01):
            if isinstance(command, Quit) and not stubborn:
                return
            if isinstance(command, Speak):
                link.send_event(Log(f"{os.getpid()} speaks {command.id}"))
            if isinstance(command, React):
                paused = {"pause": True, "go on": False}.get(command.reaction, paused)
                react(link, command)
        for block in link.poll_audio():
            link.send_event(Log(f"heard {block.shape} {block.max()}"))
        if paused:
            continue
        now = time.monotonic_ns()
        link.send_video(bytes(32), 4, 2, 16, PixelFormat.BGRA, now)
        link.send_audio(np.zeros((960, 2), np.int16), now)


def react(link: LinkClient, command: React) -> None:
    if command.reaction == "crash":
        print("segmentation fault", flush=True)
        os._exit(9)
    if command.reaction == "hang up":
        link.close("hanging up")
    if command.reaction in {"pause", "go on"}:
        link.send_event(Pause(command.reaction == "pause"))
    link.send_event(Log(command.reaction))
    if command.reaction == "freeze":
        threading.Event().wait()
    link.send_event(Completed(command.id, "OK"))


if __name__ == "__main__":
    main(*sys.argv[1:])
