"""What applications asked of other gateways, and how their sessions went on, counted since the start."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Final

from openrois.jsonrpc.latencies import Latencies

__all__ = ["Counts"]

_CALLS: Final = ("answered", "refused", "late", "lost", "unreached")
_RESUMPTIONS: Final = ("whole", "partial", "refused", "replayed")


@dataclass(slots=True)
class Counts:
    """Counts of one gateway.

    Attributes:
        calls: requests to other gateways: `answered`, `refused` with an error, `late` without an answer in time, `lost`
            with their gateway, `unreached` where no session came about.
        latencies: from these requests to their answers.
        resumptions: sessions that were resumed here, `whole` or `partial` where another gateway did not say what it has
            of them; attempts that were `refused`, and those with a token that was used before, `replayed`.
    """

    calls: Counter[str] = field(default_factory=lambda: Counter(dict.fromkeys(_CALLS, 0)))
    latencies: Latencies = field(default_factory=Latencies)
    resumptions: Counter[str] = field(default_factory=lambda: Counter(dict.fromkeys(_RESUMPTIONS, 0)))
