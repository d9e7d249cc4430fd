"""A recogniser's process that does what a grammar's word says: understands, hangs, dies, talks nonsense, is unsure."""

import os
import sys
import time

from openrois_body.processes.framing import HEADER, decode_body, decode_header, encode


def main() -> None:
    grammar, heard = "", 0
    while header := sys.stdin.buffer.read(HEADER.size):
        lengths = decode_header(header)
        request = decode_body(sys.stdin.buffer.read(lengths.body))
        heard += len(sys.stdin.buffer.read(lengths.sound)) // 2
        answer: dict[str, object] = {}
        if request["do"] == "begin":
            grammar, heard = str(request["grammar"]), 0
            if "refuse" in grammar:
                answer = {"refused": "that is not for me"}
        if request["do"] == "hear":
            if "hang" in grammar:
                time.sleep(60)
            if "die" in grammar:
                print("something broke", file=sys.stderr, flush=True)
                os._exit(3)
            answer = {"partial": "back" if "other_speech" in grammar else str(heard)}
        if request["do"] == "end":
            answer = {
                "candidates": ["stop", "stop stop", "stop"],
                "score": -50_000.0 if "mumble" in grammar else -5000.0,
                "worse": 3.0 if "worse" in grammar else 9.0 if "noise" in grammar else 0.5,
                "outside": 40 if "outside" in grammar else 0,
            }
            if "silence" in grammar:
                answer["candidates"] = []
        reply = b"nonsense, not a message" if "babble" in grammar else encode(answer)
        sys.stdout.buffer.write(reply)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
