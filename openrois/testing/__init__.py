"""Testing for those who write adapters: a harness in memory, a whole process, and the contract of every component.

    from openrois.testing import ComponentContract, harness

Nothing here needs a test runner; `ComponentContract` is made for pytest and works with any that calls methods.
"""

from openrois.testing.contract import ComponentContract, Finding, findings
from openrois.testing.memory import MemoryGateway, harness, memory_gateway
from openrois.testing.process import launched

__all__ = ["ComponentContract", "Finding", "MemoryGateway", "findings", "harness", "launched", "memory_gateway"]
