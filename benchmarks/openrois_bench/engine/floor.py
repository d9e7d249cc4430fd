"""Floor of the machine for handing a picture over at the same pace: blocking sockets and copies alone.

`ring` is a copy into memory that two processes share, 64 bytes through a Unix socket, and a copy out of it; `TCP` and
`Unix` are one `sendall` and as many `recv_into` as it takes, into memory that is used again for the next picture.
"""

import argparse
import json
import mmap
import os
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrois_bench.measuring.figures import MILLISECONDS, Percentiles

SLOTS: Final = 4
KINDS: Final = 4
"""Different pictures that are sent in turn: more than a processor keeps of one."""
BELL: Final = struct.Struct("<Q56x")
"""When the picture was there, and as much as a doorbell has beside it."""
PATIENCE: Final = 20.0


def send(chosen: argparse.Namespace) -> None:
    """Be the engine: send pictures at the pace, then print what they cost."""
    link = socket.socket(socket.AF_INET if chosen.way == "TCP" else socket.AF_UNIX)
    link.settimeout(PATIENCE)
    link.connect(("127.0.0.1", int(chosen.address)) if chosen.way == "TCP" else f"\0{chosen.address}")
    if chosen.way == "TCP":
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    pictures = [np.random.default_rng(seed).integers(0, 256, chosen.size, np.uint8).data for seed in range(KINDS)]
    with Path(chosen.ring).open("r+b") as file, mmap.mmap(file.fileno(), 0) as memory:
        start = time.monotonic()
        cpu = 0.0
        for number in range(chosen.warm + chosen.frames):
            if number == chosen.warm:
                cpu = time.process_time()
            time.sleep(max(0.0, start + number / chosen.fps - time.monotonic()))
            bell = BELL.pack(time.monotonic_ns())
            if chosen.way == "ring":
                at = number % SLOTS * chosen.size
                memory[at : at + chosen.size] = pictures[number % KINDS]
                link.sendall(bell)
            else:
                sent = link.sendmsg([bell, pictures[number % KINDS]])
                link.sendall(pictures[number % KINDS][sent - BELL.size :])
        print(json.dumps(time.process_time() - cpu))


def _receive(link: socket.socket, into: memoryview) -> None:
    while into:
        count = link.recv_into(into)
        if not count:
            raise EOFError("the sender is gone")
        into = into[count:]


def floor(way: str, size: int, frames: int, warm: int, fps: float) -> dict[str, Any]:
    """One run of one way (`ring`, `Unix`, `TCP`) for pictures of `size` bytes."""
    family = socket.AF_INET if way == "TCP" else socket.AF_UNIX
    name: Any = ("127.0.0.1", 0) if way == "TCP" else f"\0openrois-floor-{os.getpid()}"
    ring = os.memfd_create("openrois-floor")
    os.ftruncate(ring, SLOTS * size)
    with socket.create_server(name, family=family) as listener, mmap.mmap(ring, SLOTS * size) as memory:
        listener.settimeout(PATIENCE)
        memory[:] = bytes(SLOTS * size)
        at = str(listener.getsockname()[1]) if way == "TCP" else name[1:]
        arguments = ["--way", way, "--address", at, "--ring", f"/proc/{os.getpid()}/fd/{ring}", "--size", size]
        arguments += ["--frames", frames, "--warm", warm, "--fps", fps]
        command = [sys.executable, "-m", "openrois_bench.engine.floor", *map(str, arguments)]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process, listener.accept()[0] as link:
            link.settimeout(PATIENCE)
            delays, cpu = _received(link, memoryview(memory), way, size, frames, warm)
            told, _ = process.communicate(timeout=PATIENCE)
    os.close(ring)
    found = Percentiles.of(delays, MILLISECONDS)
    return {
        "way": f"floor of {way}",
        "pictures": frames,
        "missing": 0,
        "p50_ms": found.p50,
        "p95_ms": found.p95,
        "engine_cpu_ms": 1000 * float(json.loads(told)) / frames,
        "adapter_cpu_ms": 1000 * cpu / frames,
    }


def _received(
    link: socket.socket, memory: memoryview, way: str, size: int, frames: int, warm: int
) -> tuple[list[float], float]:
    """Return how long each picture took, in seconds, and the CPU time of all."""
    bell, own = memoryview(bytearray(BELL.size)), np.ones(size, np.uint8).data
    delays, cpu = [], 0.0
    for number in range(warm + frames):
        if number == warm:
            cpu = time.process_time()
        _receive(link, bell)
        if way == "ring":
            at = number % SLOTS * size
            own[:] = memory[at : at + size]
        else:
            _receive(link, own)
        delays.append((time.monotonic_ns() - BELL.unpack(bell)[0]) / 1e9)
    memory.release()
    return delays[warm:], time.process_time() - cpu


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="openrois_bench.engine.floor")
    for option, kind in {"way": str, "address": str, "ring": str, "size": int, "frames": int, "warm": int}.items():
        parser.add_argument(f"--{option}", type=kind, required=True)
    parser.add_argument("--fps", type=float, required=True)
    send(parser.parse_args())
