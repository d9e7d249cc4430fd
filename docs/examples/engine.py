"""A game engine in a few lines: its picture is a grey that gets lighter and darker, and it knows how to nod."""

import itertools
import json
import os
import select
import socket
import struct
import time

WIDTH, HEIGHT, FPS = 320, 180, 30
HEADER, VIDEO = struct.Struct("<4sBBHII"), struct.Struct("<QQIIIIII")
HELLO, VIDEO_TYPE, COMMAND, EVENT, BYE = 1, 3, 5, 6, 7


def message(kind: int, payload: bytes) -> bytes:
    """Put the header of 16 bytes in front."""
    return HEADER.pack(b"ORL1", kind, 1, 0, len(payload), 0) + payload


def answer(command: dict[str, object]) -> bytes:
    """Do what was asked, and tell that it is done; this engine nods in no time."""
    if command["command"] != "react":
        return b""
    status = "OK" if command["reaction"] == "nod" else "ERROR"
    return message(EVENT, json.dumps({"event": "completed", "id": command["id"], "status": status}).encode())


def run(link: socket.socket) -> None:
    """Greet, then show pictures and take commands until the adapter says that it is over."""
    video = {"width": WIDTH, "height": HEIGHT, "fps": FPS, "format": "bgra"}
    hello = {"name": "grey", "version": "1", "video": video, "audio": None, "reactions": ["nod"], "demand": True}
    link.sendall(message(HELLO, json.dumps({**hello, "secret": os.environ.get("OPENROIS_LINK_SECRET", "")}).encode()))
    due, unread, wanted = time.monotonic(), b"", True
    for sequence in itertools.count():
        while select.select([link], [], [], max(0.0, due - time.monotonic()))[0]:
            data = link.recv(65536)
            unread += data
            while len(unread) >= 16 and len(unread) >= (end := 16 + HEADER.unpack_from(unread)[4]):
                kind, payload, unread = unread[4], unread[16:end], unread[end:]
                if kind == BYE or (kind == COMMAND and json.loads(payload)["command"] == "quit"):
                    return
                if kind == COMMAND:
                    command = json.loads(payload)
                    if command["command"] == "demand":
                        wanted, due = command["consumers"] > 0, time.monotonic()
                    link.sendall(answer(command))
            if not data:
                return
        if not wanted:  # it draws nothing, and says now and then that it lives
            link.sendall(message(EVENT, b'{"event": "idle"}'))
            due = time.monotonic() + 0.5
            continue
        grey = round(128 + 100 * (sequence / FPS % 1))
        numbers = VIDEO.pack(sequence, time.monotonic_ns(), WIDTH, HEIGHT, 4 * WIDTH, 1, 0, 0)
        link.sendall(message(VIDEO_TYPE, numbers + bytes([grey, grey, grey, 255]) * (WIDTH * HEIGHT)))
        # What it was too late for is left out.
        due = max(due + 1 / FPS, time.monotonic())


if __name__ == "__main__":
    carrier, _, place = os.environ.get("OPENROIS_LINK_ADDRESS", "tcp:127.0.0.1:8766").partition(":")
    if carrier == "unix":
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(place)
    else:
        host, _, port = place.rpartition(":")
        connection = socket.create_connection((host, int(port)))
    run(connection)
