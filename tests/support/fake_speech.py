"""A speech process that does what the text says: `die`, `hang`, `babble` or `flood`; it refuses every other text."""

import os
import sys
import threading

from openrois_body.processes.framing import HEADER, decode_body, decode_header, encode


def answer(text: str) -> bytes:
    match text:
        case "die":
            print("out of memory", file=sys.stderr, flush=True)
            os._exit(3)
        case "hang":
            threading.Event().wait()
        case "babble":
            return b"\4\0\0\0\0\0\0\0abcd"
        case "flood":
            return b"\xff" * 64
    return encode({"refused": f"{text} {os.getpid()}"})


def main() -> None:
    while header := sys.stdin.buffer.read(HEADER.size):
        request = decode_body(sys.stdin.buffer.read(decode_header(header).body))
        sys.stdout.buffer.write(answer(request.get("text", "")))
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
