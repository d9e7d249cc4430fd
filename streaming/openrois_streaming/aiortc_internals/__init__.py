"""The only place that touches names of aiortc and aioice that are not public. `trial.self_test` says whether they hold.

* `connection`: how the sections of a peer connection are started, and what was negotiated.
* `incoming`: what stands before the packets that arrive.
* `channels`: what arrives over data channels.
* `sending`, `srtp`: a sender of our own in the place of aiortc's.
* `receiving`: a receiver of our own in the place of aiortc's.
* `ice`: the agent, with its guard.
"""
