"""What was counted of one receiver."""

from dataclasses import dataclass, fields, replace


@dataclass(frozen=True)
class ReceiverFigures:
    """What was counted of one receiver. `jitter` and `playout_delay` are in seconds.

    `frames_dropped` could not be decoded or were not read in time; `concealed` are seconds of sound that were made up.
    """

    packets: int
    bytes: int
    packets_lost: int
    nacks: int
    key_frame_requests: int
    key_frames: int
    frames_decoded: int
    frames_dropped: int
    jitter: float
    playout_delay: float
    concealed: float

    def since(self, before: "ReceiverFigures") -> "ReceiverFigures":
        """What was counted after another reading; jitter and playout delay are those of now."""
        counted = {
            field.name: getattr(self, field.name) - getattr(before, field.name)
            for field in fields(self)
            if field.name not in ("jitter", "playout_delay")
        }
        return replace(self, **counted)
