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
            answer = {"partial": str(heard)}
        if request["do"] == "end":
            score = -50_000.0 if "mumble" in grammar else -5000.0
            before = "stop" if "again" in grammar else "go"
            answer = {"candidates": ["stop", "stop stop", "stop"], "score": score, "before": before}
        reply = b"nonsense, not a message" if "babble" in grammar else encode(answer)
        sys.stdout.buffer.write(reply)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
