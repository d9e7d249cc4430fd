"""A program with the command line of Piper that speaks with espeak-ng: each sentence of each line, raw, as it is made.

Of a sentence `die` it dies, and over `hang` it hangs.
"""

import argparse
import asyncio
import sys
from pathlib import Path

from openrois_body.speech.synthesizer import Synthesizer


async def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("-m", "--model", required=True, type=Path)
    parser.add_argument("--output-raw", "--output_raw", action="store_true")
    parser.add_argument("-s", "--speaker", type=int)
    chosen = parser.parse_args()
    assert chosen.output_raw
    assert chosen.model.is_file()
    async with Synthesizer() as synthesizer:
        for line in sys.stdin:
            for sentence in filter(None, map(str.strip, line.split("."))):
                if sentence == "die":
                    sys.exit("out of memory")
                if sentence == "hang":
                    await asyncio.Event().wait()
                voice = None if chosen.speaker is None else f"f{chosen.speaker}"
                speech = await synthesizer.synthesize(sentence, voice=voice, volume=100)
                sys.stdout.buffer.write(speech.samples[::2].astype("<i2").tobytes())
                sys.stdout.buffer.flush()


if __name__ == "__main__":
    asyncio.run(main())
