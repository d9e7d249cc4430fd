"""Testing for authors of adapters: a harness in memory, a whole process, a bad connection, and a contract.

    from openrois.testing import ComponentContract, harness

Nothing here needs a test runner; `ComponentContract` is made for pytest and works with any that calls methods.
"""

from openrois.extras import MissingExtra
from openrois.testing.contract import ComponentContract, Finding, findings
from openrois.testing.memory import MemoryGateway, harness, memory_gateway
from openrois.testing.process import launched
from openrois.testing.relay import FaultRelay, Weather

__all__ = [
    "ComponentContract",
    "FaultRelay",
    "Finding",
    "MemoryGateway",
    "MissingExtra",
    "Weather",
    "findings",
    "harness",
    "launched",
    "memory_gateway",
]
