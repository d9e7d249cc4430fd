"""The tables of the paper model: the formulas are within 1.5 times of the simulator, and of a gateway over sockets."""

import pytest

from tools.pages.scale import found, scale_compared, scale_needs

WITHIN = 1.5


def test_the_formulas_are_near_what_was_simulated_and_measured() -> None:
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in scale_compared() if line]
    ratios = {row[0]: float(row[-1]) for row in rows if row[-1].replace(".", "").isdigit()}
    # Two phases of two simulations, eight kinds, and events to one and to several.
    assert len(ratios) == 4 + 8 + 2
    assert {name: ratio for name, ratio in ratios.items() if not 1 / WITHIN <= ratio <= WITHIN} == {}


@pytest.mark.parametrize("name", ["simulation", "simulation_small", "simulation_real"])
def test_results_are_of_the_commands_on_the_page(name: str) -> None:
    result = found(name)
    assert result["plan"]["seed"] == 1
    assert result["command"].endswith(f"--json benchmarks/results/{name}.json")


def test_ten_times_as_many_need_about_ten_times_as_much() -> None:
    head, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in scale_needs())
    assert head[:2] == ["bodies", "applications at work"]
    processors = [float(row[2]) for row in rows]
    assert processors == sorted(processors)
    assert processors[2] / processors[1] == pytest.approx(10, rel=0.3)
