"""The tables of the paper model: the formulas are within 1.5 times of the simulator, and of a gateway over sockets."""

import pytest

from tools.pages.scale import found, scale_compared, scale_needs, scale_others

WITHIN = 1.5


def test_the_formulas_are_near_what_was_simulated_and_measured() -> None:
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in scale_compared() if line]
    ratios = {row[0]: float(row[-1]) for row in rows if row[-1].replace(".", "").isdigit()}
    # Two phases of two simulations, nine kinds, and events to one and to several, each also in bursts.
    assert len(ratios) == 4 + 9 + 4
    assert {name: ratio for name, ratio in ratios.items() if not 1 / WITHIN <= ratio <= WITHIN} == {}


def test_the_formulas_are_near_what_other_programs_measured() -> None:
    _, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in scale_others())
    # Queries, deliveries, and two sizes of a fleet with attaching and memory.
    assert len(rows) == 2 + 2 * 2
    assert {row[0]: row[-1] for row in rows if not 1 / WITHIN <= float(row[-1]) <= WITHIN} == {}


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
