"""What is asked of a sender whose pictures do not arrive whole: lost packets again, or a key frame. Pure."""

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

# Packets that may be asked for and not yet be there: at least what passes through 1 Mbit/s in 0.3 s.
_LEAST_WINDOW, _LARGEST_WINDOW = 32, 256


class RoundTrip:
    """The time from a request to what was asked for, in seconds, with all that waits on the way."""

    def __init__(self) -> None:
        self.seconds = _FIRST_GUESS
        self.measured = False
        self._variation = _FIRST_GUESS / 4
        self._back_off = 1

    def measure(self, seconds: float) -> None:
        """The answer to a request that was made once took `seconds`."""
        self._back_off = 1
        if self.measured:
            self._variation += _VARIATION_SMOOTHING * (abs(seconds - self.seconds) - self._variation)
            self.seconds += _SMOOTHING * (seconds - self.seconds)
        else:
            self.seconds, self._variation, self.measured = seconds, seconds / 2, True

    def timed_out(self) -> None:
        """A request was not answered in time: perhaps that is too short."""
        self._back_off = min(2 * self._back_off, _MOST_BACK_OFF)

    @property
    def patience(self) -> float:
        """How long a lost packet is waited for: 100 to 200 ms."""
        return max(_SHORTEST_WAIT, min(2.5 * self.seconds, _LONGEST_WAIT))

    @property
    def retry(self) -> float:
        """When a request is worth repeating: an answer to it would be there, even behind the usual jitter."""
        waits = self.seconds + max(_LEAST_JITTER, _VARIATIONS * self._variation)
        return max(_SHORTEST_RETRY, min(waits * self._back_off, _LONGEST_RETRY))

    @property
    def key_frame_patience(self) -> float:
        """How long the next repaired packet of a key frame is waited for: another one would cost more than that."""
        return max(self.patience, min(2 * self.retry, _LONGEST_KEY_FRAME_WAIT))


class RepairWindow:
    """How many packets may be on their way again at a time, so that a path that is full is not filled by repetitions.

    It grows by each packet that comes, and is halved once per round trip in which one does not; after that it grows by
    one in the time in which all of it come (as in RFC 5681 section 3.1).
    """

    def __init__(self) -> None:
        self.packets: float = _LEAST_WINDOW
        self._threshold: float = _LARGEST_WINDOW
        self._halved_at = float("-inf")

    def came(self) -> None:
        """A packet came that was asked for."""
        self.packets = min(self.packets + (1 if self.packets < self._threshold else 1 / self.packets), _LARGEST_WINDOW)

    def failed(self, asked_at: float, now: float) -> bool:
        """A packet that was asked for at `asked_at` did not come in time; returns whether that is news."""
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
    """The packets that are missing, by unwrapped sequence number, and when each is asked for (RFC 4585 section 6.2.1).

    At once when it is noticed, and again when an answer would be there, after longer and longer times, ten times at
    most; and no more at a time than the path is seen to repair.
    """

    def __init__(self, round_trip: RoundTrip) -> None:
        self.repaired_at = float("-inf")
        """When something came last that was asked for."""
        self._round_trip = round_trip
        self._window = RepairWindow()
        self._held_back_at: float | None = None
        self._lost: dict[int, _Lost] = {}

    def __len__(self) -> int:
        return len(self._lost)

    def add(self, sequences: range, now: float) -> None:
        """They are missing."""
        for sequence in sequences:
            self._lost[sequence] = _Lost(now)

    def arrived(self, sequence: int, now: float) -> None:
        """It came after all."""
        lost = self._lost.pop(sequence, None)
        if lost is not None and lost.tries:
            if lost.tries == 1:
                # With more than one request it is not known which of them was answered (Karn's algorithm).
                self._round_trip.measure(now - lost.asked_at)
            self._window.came()
            self.repaired_at = now

    def forget_before(self, sequence: int) -> None:
        """What is older is not waited for any more."""
        for old in [each for each in self._lost if each < sequence]:
            del self._lost[old]

    def noticed_at(self, sequence: int) -> float | None:
        """When it was missed; None if it is not."""
        lost = self._lost.get(sequence)
        return None if lost is None else lost.noticed_at

    def to_ask_for(self, now: float) -> tuple[int, ...]:
        """The packets to ask for now, in order; they count as asked for."""
        due = sorted(sequence for sequence, lost in self._lost.items() if lost.tries < _TRIES and lost.next_at <= now)
        for lost in map(self._lost.__getitem__, due):
            if lost.tries and self._window.failed(lost.asked_at, now):
                self._round_trip.timed_out()
        chosen = due[: max(int(self._window.packets) - self._on_their_way(now), 0)]
        for lost in map(self._lost.__getitem__, chosen):
            lost.asked_at, lost.next_at = now, now + min(self._round_trip.retry * 2**lost.tries, _LONGEST_RETRY)
            lost.tries += 1
        # The others are asked for when there is room: what is on its way comes, or counts as lost.
        self._held_back_at = now if len(chosen) < len(due) else None
        return tuple(chosen)

    def _on_their_way(self, now: float) -> int:
        return sum(1 for lost in self._lost.values() if lost.tries and lost.next_at > now)

    @property
    def next_at(self) -> float | None:
        """When there is something to ask for next."""
        times = [lost.next_at for lost in self._lost.values() if lost.tries < _TRIES]
        if self._held_back_at is not None:
            times = [at for at in times if at > self._held_back_at] or times
        return min(times, default=None)


class KeyFrameWish:
    """Whether a key frame is wanted, and when to say so (RFC 4585 section 6.3.1).

    At once, and after longer and longer times if none comes: where key frames do not get through, more of them do not
    either.
    """

    def __init__(self, round_trip: RoundTrip) -> None:
        self._round_trip = round_trip
        self._asked_at: float | None = None
        self._pause = _KEY_FRAME_INTERVAL
        self.wanted = False

    def fulfilled(self) -> None:
        """One came."""
        self.wanted = False
        self._asked_at, self._pause = None, _KEY_FRAME_INTERVAL

    @property
    def next_at(self) -> float | None:
        """When to ask; None if none is wanted."""
        if not self.wanted:
            return None
        if self._asked_at is None:
            return 0.0
        return self._asked_at + max(self._pause, 2 * self._round_trip.seconds)

    def due(self, now: float) -> bool:
        """Whether to ask now; if so, it counts as asked."""
        at = self.next_at
        if at is None or at > now:
            return False
        if self._asked_at is not None:
            self._pause = min(2 * self._pause, _LONGEST_KEY_FRAME_INTERVAL)
        self._asked_at = now
        return True
