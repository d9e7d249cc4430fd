import pytest
from openrois_bench.engine.floor import floor


@pytest.mark.engine
@pytest.mark.parametrize("way", ["ring", "Unix", "TCP"])
def test_floor_of_the_machine_is_measured(way: str) -> None:
    found = floor(way, size=5000, frames=3, warm=1, fps=200)
    assert (found["way"], found["pictures"]) == (f"floor of {way}", 3)
    assert found["p95_ms"] >= found["p50_ms"] > 0
    assert found["engine_cpu_ms"] > 0
    assert found["adapter_cpu_ms"] > 0
