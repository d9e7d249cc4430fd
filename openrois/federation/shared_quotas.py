"""What subjects have at each gateway of a cluster: what this gateway tells the others, and what it was told. Pure.

The share of a subject is what it may have, divided by the number of gateways. A gateway tells of the subjects that have
their share or more, here or at a gateway that told so. Of a subject of which none tells, all gateways together have
less than it may have; of any other each gateway knows what all have. Of 100,000 subjects few are told of.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from typing import Annotated, Any, Final

from pydantic import Field

from openrois.aio.listeners import Listeners
from openrois.auth.subject_quotas import SubjectQuotas, Usage
from openrois.types.model import Model

__all__ = ["MOST_TOLD", "TELLING_INTERVAL", "TOLD", "TOLD_AT_ONCE", "SharedQuotas"]

TELLING_INTERVAL: Final = 0.5
"""Seconds between two tellings: it takes two until all know all of a subject, and two seconds are promised."""

TOLD_AT_ONCE: Final = 1024
"""Subjects of one telling; what has changed of more of them is told by the next ones."""

MOST_TOLD: Final = 16_384
"""Subjects of one gateway that others are told of at a time; more count at their gateway alone."""

TOLD: Final = "openrois.cluster.quotas"
"""Notification to another gateway: what subjects have here from now on."""

_LOOKED_AT: Final = 4096
"""Subjects that are looked at before one telling: all are due when a gateway comes or goes."""

_NOTHING: Final = Usage()

Count = Annotated[int, Field(ge=0)]


class _Told(Model):
    """Params of `TOLD`: connections, sessions and streams of some subjects; nothing of one is told no more."""

    gateway: Annotated[str, Field(max_length=128)]
    used: Annotated[
        dict[str, Annotated[tuple[Count, Count, Count], Field(strict=False)]], Field(max_length=TOLD_AT_ONCE)
    ]


@dataclass(slots=True)
class _Heard:
    source: object
    used: dict[str, Usage] = field(default_factory=dict)


class SharedQuotas:
    """The quotas of the subjects of a cluster, as one gateway knows them.

    Args:
        gateway_id: of this gateway.
        quotas: of this gateway; what others tell counts there from now on.
    """

    def __init__(self, gateway_id: str, quotas: SubjectQuotas) -> None:
        self._gateway_id = gateway_id
        self._quotas = quotas
        self._share = quotas.most
        self._heard: dict[str, _Heard] = {}
        self._told: dict[str, Usage] = {}
        self._due: dict[str, None] = {}
        self._absent: Counter[str] = Counter()
        self._tellers: Listeners[Mapping[str, Usage]] = Listeners()
        quotas.on_change = self._note
        quotas.elsewhere = self._elsewhere

    def _note(self, name: str) -> None:
        self._due[name] = None

    def _elsewhere(self, name: str) -> Usage:
        found = [heard.used[name] for heard in self._heard.values() if name in heard.used]
        return Usage(*map(sum, zip(*found, strict=True))) if found else _NOTHING

    # What this gateway tells.

    @contextmanager
    def telling(self, notify: Callable[[str, Mapping[str, Any]], None]) -> Iterator[None]:
        """Tell another gateway what there is, and what changes while the block runs.

        Args:
            notify: sends it a notification.
        """

        def tell(used: Mapping[str, Usage]) -> None:
            notify(TOLD, {"gateway": self._gateway_id, "used": used})

        left = iter(self._told.items())
        while page := dict(islice(left, TOLD_AT_ONCE)):
            tell(page)
        stop = self._tellers.add(tell)
        try:
            yield
        finally:
            stop()

    def tell_changes(self, gateways: int) -> None:
        """Tell all other gateways what has changed, as far as it concerns them.

        Args:
            gateways: how many there are now, this one too.
        """
        connections, sessions, streams = (-(-most // max(gateways, 1)) for most in self._quotas.most)
        share = Usage(connections, sessions, streams)
        if share != self._share:
            self._share = share
            self._due |= dict.fromkeys((*self._told, *self._quotas.names(), *self._absent))
        absent = self._quotas.count_absent()
        if absent != self._absent:
            self._due |= dict.fromkeys(name for name in absent | self._absent if absent[name] != self._absent[name])
            self._absent = absent
        changed: dict[str, Usage] = {}
        for name in tuple(islice(self._due, _LOOKED_AT)):
            if len(changed) == TOLD_AT_ONCE:
                break
            del self._due[name]
            usage = self._to_tell(name)
            if usage != self._told.get(name, _NOTHING) and self._keep(name, usage):
                changed[name] = usage
        if changed:
            self._tellers.notify_all(changed)

    def _to_tell(self, name: str) -> Usage:
        """Return what others have to know of a subject."""
        here = self._quotas.usage(name, self._absent[name])
        if self._has_share(here):
            return here
        found = (heard.used.get(name, _NOTHING) for heard in self._heard.values())
        return here if any(map(self._has_share, found)) else _NOTHING

    def _has_share(self, usage: Usage) -> bool:
        share = self._share
        return usage[0] >= share[0] or usage[1] >= share[1] or usage[2] >= share[2]

    def _keep(self, name: str, usage: Usage) -> bool:
        """Note what others are told of a subject; tell whether there is room for that."""
        if usage == _NOTHING:
            del self._told[name]
        elif name in self._told or len(self._told) < MOST_TOLD:
            self._told[name] = usage
        else:
            return False
        return True

    # What it was told.

    @contextmanager
    def hearing(self) -> Iterator[Callable[[Mapping[str, Any]], None]]:
        """Yield a handler of `TOLD` for one connection; what came over it is forgotten when the block ends.

        A gateway that dials anew begins anew, while its former connection may not have ended here.
        """
        source, gateway_ids = object(), set[str]()

        def hear(params: Mapping[str, Any]) -> None:
            told = _Told.read_newer(params)
            heard = self._heard.get(told.gateway)
            if heard is None or heard.source is not source:
                self._forget(told.gateway)
                heard = self._heard[told.gateway] = _Heard(source)
                gateway_ids.add(told.gateway)
            for name, counts in told.used.items():
                self._hear_of(name, Usage(*counts), heard.used)

        try:
            yield hear
        finally:
            for gateway_id in gateway_ids:
                if gateway_id in self._heard and self._heard[gateway_id].source is source:
                    self._forget(gateway_id)

    def _hear_of(self, name: str, usage: Usage, used: dict[str, Usage]) -> None:
        if usage == _NOTHING:
            used.pop(name, None)
        elif name in used or len(used) < MOST_TOLD:
            used[name] = usage
        self._look_again(name)

    def _forget(self, gateway_id: str) -> None:
        heard = self._heard.pop(gateway_id, None)
        for name in heard.used if heard is not None else ():
            self._look_again(name)

    def _look_again(self, name: str) -> None:
        """Look before the next telling whether others have to know of a subject, if it has something here."""
        if name in self._quotas or name in self._absent or name in self._told:
            self._due[name] = None
