"""Values: any text of any type fits or is refused with `ValueError`, and what fits can be converted."""

import json
import math
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.types.values import check_value

types = st.sampled_from(["int", "double", "bool", "string", "Component_Status"])
suffixes = st.sampled_from(["", "[]", "[][]"])
scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
lists = st.recursive(scalars, lambda inner: st.lists(inner, max_size=4), max_leaves=10)


@settings(max_examples=90)
@given(types, suffixes, st.text(max_size=30) | scalars.map(str) | lists.map(json.dumps))
def test_any_value(kind: str, suffix: str, value: str) -> None:
    if not fits(kind + suffix, value):
        return
    if suffix:
        converted(kind, json.loads(value), suffix)
    elif kind == "int":
        assert abs(int(value)) < 10**20
    elif kind == "double":
        assert math.isfinite(float(value))


def fits(type_code: str, value: str) -> bool:
    try:
        check_value(type_code, value)
    except ValueError:
        return False
    return True


def converted(kind: str, value: Any, suffix: str) -> None:
    if suffix:
        assert isinstance(value, list)
        for item in value:
            converted(kind, item, suffix.removesuffix("[]"))
    else:
        python = {"int": int, "double": (int, float), "bool": bool, "string": str, "Component_Status": str}[kind]
        assert isinstance(value, python)  # type: ignore[arg-type]
