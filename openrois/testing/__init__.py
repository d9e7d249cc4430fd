"""Testing for those who write adapters: a harness in memory, a whole process, a bad connection, and a contract.

    from openrois.testing import ComponentContract, harness

Nothing here needs a test runner; `ComponentContract` is made for pytest and works with any that calls methods.
"""

from openrois.testing.contract import ComponentContract, Finding, findings
from openrois.testing.memory import MemoryGateway, harness, memory_gateway
from openrois.testing.process import launched
from openrois.testing.relay import FaultRelay, Weather

__all__ = [
    "ComponentContract",
    "FaultRelay",
    "Finding",
    "MemoryGateway",
    "Weather",
    "findings",
    "harness",
    "launched",
    "memory_gateway",
]
