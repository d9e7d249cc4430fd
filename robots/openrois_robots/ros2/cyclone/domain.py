"""DDS domains of this process: its participants share one, and it announces them often."""

import os
import threading
from collections import Counter
from typing import Final

from cyclonedds.domain import Domain

__all__ = ["join_domain", "leave_domain"]

_ANNOUNCING: Final = "<CycloneDDS><Domain><Discovery><SPDPInterval>1s</SPDPInterval></Discovery></Domain></CycloneDDS>"
"""Announces participants each second, not every 30: a node that was frozen has forgotten them, and answers to that."""

_domains: Final[dict[int, Domain]] = {}
_users: Final[Counter[int]] = Counter()
_lock: Final = threading.Lock()


def join_domain(number: int) -> None:
    """Have a domain until `leave_domain`; what CYCLONEDDS_URI says goes before what is set here.

    Raises:
        DDSException: it cannot be had.
    """
    with _lock:
        if not _users[number]:
            _domains[number] = Domain(number, f"{_ANNOUNCING},{os.environ.get('CYCLONEDDS_URI', '')}")
        _users[number] += 1


def leave_domain(number: int) -> None:
    """Undo one `join_domain`; its participants have to be deleted before."""
    with _lock:
        _users[number] -= 1
        if not _users[number]:
            _domains.pop(number).__del__()
