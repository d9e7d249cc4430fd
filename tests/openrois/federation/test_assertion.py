"""What a gateway asserts of an application is read as it was said, or refused with what is wrong."""

from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.errors import BadParameter
from openrois.federation.assertion import MAX_SCOPE, Assertion

ANN = Principal("ann", frozenset({Role.OPERATOR, Role.VIEWER}), ("robot/*",), 1234.5, "t-1", "person")


def test_a_principal_comes_back_as_it_was() -> None:
    said = Assertion.of(ANN, address="192.0.2.7", client_id="c", line="l", generation=3).hello()
    read = Assertion.parse(said)
    # The gateway that asserts it ends the session in time.
    assert read.expires == ANN.expires
    assert read.principal == replace(ANN, expires=None)
    assert (read.address, read.client_id, read.line, read.generation) == ("192.0.2.7", "c", "l", 3)


def test_without_tokens_it_is_the_local_one() -> None:
    assert Assertion.parse(Assertion.of(LOCAL).hello()).principal is LOCAL


def test_a_scope_that_is_too_long_goes_nowhere() -> None:
    with pytest.raises(BadParameter, match=f"513 patterns goes to no other gateway: {MAX_SCOPE} do"):
        Assertion.of(Principal("ann", frozenset(), ("robot/*",) * (MAX_SCOPE + 1)))


@pytest.mark.parametrize(
    "flaw",
    [
        {"kind": "root"},
        {"subject": 7},
        {"subject": "x" * 1025},
        {"roles": ["emperor"]},
        {"roles": "operator"},
        {"scope": ["*"] * (MAX_SCOPE + 1)},
        {"rank": "x" * 65},
        {"generation": -1},
        {"line": "x" * 65},
    ],
    ids=str,
)
def test_what_is_no_assertion_is_refused(flaw: dict[str, object]) -> None:
    with pytest.raises(BadParameter, match="what the gateway asserts is no principal"):
        Assertion.parse({**Assertion.of(ANN).hello(), **flaw})


def test_a_gateway_of_an_earlier_version_asserts_no_rank() -> None:
    said = Assertion.of(ANN).hello()
    del said["rank"]
    assert Assertion.parse(said).principal.rank == ""


def test_what_a_newer_gateway_says_besides_is_passed_over() -> None:
    said = Assertion.of(ANN, line="l").hello()
    assert Assertion.parse({**said, "colour": "red"}) == Assertion.parse(said)


@given(st.dictionaries(st.text(max_size=10), st.none() | st.integers() | st.text() | st.lists(st.text())))
def test_anything_is_read_or_refused(said: dict[str, object]) -> None:
    with suppress(BadParameter):
        Assertion.parse(said)
