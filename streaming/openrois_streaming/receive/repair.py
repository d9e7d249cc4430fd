"""Requests to a sender whose pictures arrive incomplete: lost packets, or a key frame. Pure."""

_FIRST_GUESS = 0.1
# As in RFC 6298 section 2.
_SMOOTHING, _VARIATION_SMOOTHING = 0.125, 0.25
_SHORTEST_RETRY, _LONGEST_RETRY = 0.02, 0.5
_LEAST_JITTER, _VARIATIONS = 0.01, 2
_MOST_BACK_OFF = 4
_TRIES = 10
_LONGEST_WAIT, _SHORTEST_WAIT = 0.2, 0.1
_LONGEST_KEY_FRAME_WAIT = 1.0
_KEY_FRAME_INTERVAL, _LONGEST_KEY_FRAME_INTERVAL = 0.3, 2.4

# Bounds of the packets under request: at least those that pass through 1 Mbit/s in 0.3 s.
_LEAST_WINDOW, _LARGEST_WINDOW = 32, 256


class RoundTrip:
    """Time from a request to the requested packet, in seconds, with all queues on the path."""

    def __init__(self) -> None:
        self.seconds = _FIRST_GUESS
        self.measured = False
        self._variation = _FIRST_GUESS / 4
        self._back_off = 1

    def measure(self, seconds: float) -> None:
        """Add a measurement: the answer to a request that was made once took `seconds`."""
        self._back_off = 1
        if self.measured:
            self._variation += _VARIATION_SMOOTHING * (abs(seconds - self.seconds) - self._variation)
            self.seconds += _SMOOTHING * (seconds - self.seconds)
        else:
            self.seconds, self._variation, self.measured = seconds, seconds / 2, True

    def timed_out(self) -> None:
        """Back off: a request was not answered in time."""
        self._back_off = min(2 * self._back_off, _MOST_BACK_OFF)

    @property
    def patience(self) -> float:
        """Seconds that a lost packet is awaited: 0.1 to 0.2."""
        return max(_SHORTEST_WAIT, min(2.5 * self.seconds, _LONGEST_WAIT))

    @property
    def retry(self) -> float:
        """Seconds after which a request is repeated: an answer would be there, even behind the usual jitter."""
        waits = self.seconds + max(_LEAST_JITTER, _VARIATIONS * self._variation)
        return max(_SHORTEST_RETRY, min(waits * self._back_off, _LONGEST_RETRY))

    @property
    def key_frame_patience(self) -> float:
        """Seconds that the next repaired packet of a key frame is awaited: another key frame would cost more."""
        return max(self.patience, min(2 * self.retry, _LONGEST_KEY_FRAME_WAIT))


class RepairWindow:
    """Window of packets under repair at a time, so that repetitions do not fill a full path.

    It grows by each packet that comes, and is halved once per round trip in which one does not; after that it grows by
    one in the time in which a whole window comes (as in RFC 5681 section 3.1).
    """

    def __init__(self) -> None:
        self.packets: float = _LEAST_WINDOW
        self._threshold: float = _LARGEST_WINDOW
        self._halved_at = float("-inf")

    def came(self) -> None:
        """Grow: a requested packet came."""
        self.packets = min(self.packets + (1 if self.packets < self._threshold else 1 / self.packets), _LARGEST_WINDOW)

    def failed(self, asked_at: float, now: float) -> bool:
        """Shrink after a packet requested at `asked_at` did not come; whether that is the first of its round trip."""
        news = asked_at > self._halved_at
        if news:
            self.packets = self._threshold = max(self.packets / 2, _LEAST_WINDOW)
            self._halved_at = now
        return news


class _Lost:
    __slots__ = ("asked_at", "next_at", "noticed_at", "tries")

    def __init__(self, now: float) -> None:
        self.noticed_at = self.next_at = self.asked_at = now
        self.tries = 0


class Losses:
    """Missing packets, by unwrapped sequence number, and the times to request each (RFC 4585 section 6.2.1).

    A packet is requested when its loss is noticed, and again when an answer would be there, after longer and longer
    times, ten times at most; and no more at a time than the repair window.
    """

    def __init__(self, round_trip: RoundTrip) -> None:
        self.repaired_at = float("-inf")
        """Time at which a requested packet came last."""
        self._round_trip = round_trip
        self._window = RepairWindow()
        self._held_back_at: float | None = None
        self._lost: dict[int, _Lost] = {}

    def __len__(self) -> int:
        return len(self._lost)

    def add(self, sequences: range, now: float) -> None:
        """Add missing packets."""
        for sequence in sequences:
            self._lost[sequence] = _Lost(now)

    def arrived(self, sequence: int, now: float) -> None:
        """Remove a packet that came after all."""
        lost = self._lost.pop(sequence, None)
        if lost is not None and lost.tries:
            if lost.tries == 1:
                # With more than one request it is not known which of them was answered (Karn's algorithm).
                self._round_trip.measure(now - lost.asked_at)
            self._window.came()
            self.repaired_at = now

    def forget_before(self, sequence: int) -> None:
        """Stop waiting for packets before `sequence`."""
        for old in [each for each in self._lost if each < sequence]:
            del self._lost[old]

    def noticed_at(self, sequence: int) -> float | None:
        """Return when a packet was noticed to be missing; None if it is not."""
        lost = self._lost.get(sequence)
        return None if lost is None else lost.noticed_at

    def to_ask_for(self, now: float) -> tuple[int, ...]:
        """Return the packets to request now, in order; they count as requested."""
        due = sorted(sequence for sequence, lost in self._lost.items() if lost.tries < _TRIES and lost.next_at <= now)
        for lost in map(self._lost.__getitem__, due):
            if lost.tries and self._window.failed(lost.asked_at, now):
                self._round_trip.timed_out()
        chosen = due[: max(int(self._window.packets) - self._on_their_way(now), 0)]
        for lost in map(self._lost.__getitem__, chosen):
            lost.asked_at, lost.next_at = now, now + min(self._round_trip.retry * 2**lost.tries, _LONGEST_RETRY)
            lost.tries += 1
        # The others are requested when there is room: packets under way come, or count as lost.
        self._held_back_at = now if len(chosen) < len(due) else None
        return tuple(chosen)

    def _on_their_way(self, now: float) -> int:
        return sum(1 for lost in self._lost.values() if lost.tries and lost.next_at > now)

    @property
    def next_at(self) -> float | None:
        """Time of the next request; None without missing packets."""
        times = [lost.next_at for lost in self._lost.values() if lost.tries < _TRIES]
        if self._held_back_at is not None:
            times = [at for at in times if at > self._held_back_at] or times
        return min(times, default=None)


class KeyFrameWish:
    """Wish for a key frame, and the times to request it (RFC 4585 section 6.3.1).

    It is requested at once, and after longer and longer times if none comes: where key frames are lost, more of them
    are lost too.
    """

    def __init__(self, round_trip: RoundTrip) -> None:
        self._round_trip = round_trip
        self._asked_at: float | None = None
        self._pause = _KEY_FRAME_INTERVAL
        self.wanted = False

    def fulfilled(self) -> None:
        """Clear the wish: a key frame came."""
        self.wanted = False
        self._asked_at, self._pause = None, _KEY_FRAME_INTERVAL

    @property
    def next_at(self) -> float | None:
        """Time of the next request; None if no key frame is wanted."""
        if not self.wanted:
            return None
        if self._asked_at is None:
            return 0.0
        return self._asked_at + max(self._pause, 2 * self._round_trip.seconds)

    def due(self, now: float) -> bool:
        """Tell whether to request a key frame now; it then counts as requested."""
        at = self.next_at
        if at is None or at > now:
            return False
        if self._asked_at is not None:
            self._pause = min(2 * self._pause, _LONGEST_KEY_FRAME_INTERVAL)
        self._asked_at = now
        return True
