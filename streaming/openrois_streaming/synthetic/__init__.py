"""Synthetic pictures and sounds for tests: received media can be compared with the known original.

Give them to a publisher like any source::

    clock = SystemClock()
    video = VideoPublisher(ColourBars(clock=clock), clock=clock, stamp=True)
    audio = AudioPublisher(Tone(clock=clock), clock=clock)

Published with `stamp=True`, each picture carries its number and the time of its capture (see `stamp`), from which loss
and delay follow. At each whole second of wall time the tone sounds and the lamp in the picture lights up: a pair that
shows the lip sync to a person, to a camera and, beside the stamp, to a machine.
"""

from openrois_streaming.errors import needing_libraries

with needing_libraries():
    from openrois_streaming.synthetic.bars import ColourBars
    from openrois_streaming.synthetic.head import TalkingHead
    from openrois_streaming.synthetic.marks import MARKER_HZ, MARKER_SECONDS
    from openrois_streaming.synthetic.tone import Tone

__all__ = ["MARKER_HZ", "MARKER_SECONDS", "ColourBars", "TalkingHead", "Tone"]
