"""Input messages of all kinds, for property tests."""

import string

from hypothesis import strategies as st
from openrois_streaming.input.messages import (
    Button,
    Change,
    Gamepad,
    Held,
    Key,
    Pad,
    Pointer,
    Release,
    Touch,
    TouchPoint,
    Wheel,
)

CODES = st.text(string.ascii_letters + string.digits, min_size=1, max_size=32)
UNIT = st.floats(0, 1)
STAMP = {"seq": st.integers(0, 2**53 - 1), "t": st.floats(0, 1e12)}
TOUCHES = st.builds(Touch, st.integers(0, 2**31), UNIT, UNIT)
HELD = st.builds(
    Held,
    st.frozensets(CODES, max_size=16),
    st.none() | st.builds(Pointer, UNIT, UNIT, st.integers(0, 31)),
    st.lists(TOUCHES, max_size=10, unique_by=lambda touch: touch.id).map(tuple),
    st.none()
    | st.builds(
        Gamepad, st.lists(st.floats(-1, 1), max_size=4).map(tuple), st.lists(st.floats(0, 1), max_size=17).map(tuple)
    ),
)
CHANGES: st.SearchStrategy[Change] = st.one_of(
    st.builds(Key, **STAMP, code=CODES, down=st.booleans()),
    st.builds(Button, **STAMP, button=st.integers(0, 4), down=st.booleans(), x=UNIT, y=UNIT),
    st.builds(Wheel, **STAMP, dx=st.floats(-1e5, 1e5), dy=st.floats(-1e5, 1e5), x=UNIT, y=UNIT),
    st.builds(TouchPoint, **STAMP, down=st.booleans(), touch=TOUCHES),
    st.builds(Pad, **STAMP, button=st.integers(0, 16), down=st.booleans()),
    st.builds(Release, **STAMP, why=st.sampled_from(["blur", "hidden", "bye", "lost"])),
)
