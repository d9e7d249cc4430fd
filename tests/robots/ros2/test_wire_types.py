"""Messages are on the wire as ROS has them: byte for byte as rosbags writes them, which is not made by us."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import openrois_robots.ros2.interfaces as bundled
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.interfaces.definitions import DefinitionError, FieldType, MessageDefinition
from openrois_robots.ros2.interfaces.derived import action_messages
from openrois_robots.ros2.interfaces.store import DISTRIBUTIONS, Interfaces
from rosbags.typesys import Stores, get_typestore

BUNDLED = Path(next(iter(bundled.__path__)))
GO = "nav2_msgs/action/NavigateToPose"
STORES = {
    "humble": Stores.ROS2_HUMBLE,
    "jazzy": Stores.ROS2_JAZZY,
    "kilted": Stores.ROS2_KILTED,
    "lyrical": Stores.ROS2_LYRICAL,
}
NUMPY = {"bool": np.bool_, "byte": np.uint8, "char": np.uint8}
FILLER = "structure_needs_at_least_one_member"


def names() -> list[str]:
    """Return every message that comes with this distribution, and the parts of its services and actions."""
    found = [str(path.relative_to(BUNDLED / "share").with_suffix("")) for path in (BUNDLED / "share").rglob("*.msg")]
    cancel = [f"action_msgs/srv/CancelGoal_{part}" for part in ("Request", "Response")]
    parts = ("Goal", "Result", "Feedback", "FeedbackMessage")
    services = [f"{each}_{way}" for each in ("SendGoal", "GetResult") for way in ("Request", "Response")]
    return sorted([*found, *cancel, *(f"{GO}_{part}" for part in (*parts, *services))])


class Both:
    """The types of a distribution, as we and as rosbags have them."""

    def __init__(self, distribution: str) -> None:
        self.interfaces = Interfaces(distribution)
        self.types = TypeMaker(self.interfaces)
        self.store = get_typestore(STORES[distribution])
        self.interfaces.service("action_msgs/srv/CancelGoal")
        action_messages(self.interfaces.action(GO))
        lacking = {name for name in names() if name not in self.store.fielddefs}
        self.store.register({name: _fielddefs(self.interfaces.message(name)) for name in sorted(lacking)})

    def value(self, name: str, values: Mapping[str, Any]) -> Any:
        """Return a message of rosbags."""
        made = {}
        for field in self.interfaces.message(name).fields:
            value, kind = values[field.name], field.type
            if kind.array is None:
                made[field.name] = value if kind.is_primitive else self.value(kind.name, value)
            elif kind.name == "string":
                made[field.name] = value
            elif kind.is_primitive:
                made[field.name] = np.array(list(value), NUMPY.get(kind.name, kind.name))
            else:
                made[field.name] = [self.value(kind.name, each) for each in value]
        return self.store.types[name](**(made or {FILLER: 0}))


def _fielddefs(definition: MessageDefinition) -> Any:
    """Return a definition that rosbags does not have as it has them."""
    from rosbags.interfaces import Nodetype

    def kind_of(kind: FieldType) -> Any:
        base = (Nodetype.BASE, (kind.name, 0)) if kind.is_primitive else (Nodetype.NAME, kind.name)
        if kind.array is None:
            return base
        return (Nodetype.ARRAY if kind.array.is_fixed else Nodetype.SEQUENCE, (base, kind.array.length or 0))

    fields = [(each.name, kind_of(each.type)) for each in definition.fields]
    return [], fields or [(FILLER, (Nodetype.BASE, ("uint8", 0)))]


BOTH = {distribution: Both(distribution) for distribution in DISTRIBUTIONS}


def values_of(interfaces: Interfaces, name: str) -> st.SearchStrategy[dict[str, Any]]:
    """Return any values of a message's fields."""
    return st.fixed_dictionaries(
        {field.name: _field(interfaces, field.type) for field in interfaces.message(name).fields}
    )


def _field(interfaces: Interfaces, kind: FieldType) -> st.SearchStrategy[Any]:
    single = _single(interfaces, kind.name)
    if kind.array is None:
        return single
    length = kind.array.length
    least, most = (length, length) if kind.array.is_fixed else (0, length or 4)
    if kind.name == "uint8":
        return st.binary(min_size=least or 0, max_size=most)
    return st.lists(single, min_size=least or 0, max_size=most)


def _single(interfaces: Interfaces, name: str) -> st.SearchStrategy[Any]:
    if name == "bool":
        return st.booleans()
    if name == "string":
        return st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=12)
    if name in ("float32", "float64"):
        return st.floats(width=int(name[5:]))  # type: ignore[arg-type]
    if "/" in name:
        return values_of(interfaces, name)
    bits = int(name.removeprefix("u")[3:])
    low = 0 if name.startswith("u") else -(1 << bits - 1)
    return st.integers(low, low + (1 << bits) - 1)


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_the_bundled_definitions_are_those_of_the_distribution(distribution: str) -> None:
    both, own = BOTH[distribution], get_typestore(STORES[distribution])
    compared = [name for name in names() if name in own.fielddefs]
    assert len(compared) > 20
    for name in compared:
        assert _fielddefs(both.interfaces.message(name))[1] == list(own.fielddefs[name][1]), name


@pytest.mark.parametrize("name", names())
@given(data=st.data())
def test_a_message_is_the_same_bytes(name: str, data: st.DataObject) -> None:
    for both in BOTH.values() if "NavigateToPose" in name else (BOTH["jazzy"],):
        values = data.draw(values_of(both.interfaces, name))
        ours = both.types.value(name, values)
        theirs = bytes(both.store.serialize_cdr(both.value(name, values), name))
        assert ours.serialize(use_version_2=False) == theirs
        # DDS pads to whole words, and what comes from another is read as what was meant.
        read = both.types.message(name).codec.deserialize(theirs + bytes(-len(theirs) % 4))
        assert read.serialize(use_version_2=False) == theirs


@pytest.mark.parametrize(("name", "size"), [("geometry_msgs/msg/Twist", 52), ("geometry_msgs/msg/PoseStamped", 76)])
def test_the_declared_type_and_the_codec_write_the_same(name: str, size: int) -> None:
    types = BOTH["jazzy"].types
    kind = types.message(name)
    data = types.value(name, {}).serialize(use_version_2=False)
    assert len(data) == size
    assert kind.declared.deserialize(data).serialize(use_version_2=False) == data


def test_bytes_are_bytes_and_not_lists_of_numbers() -> None:
    types = BOTH["jazzy"].types
    picture = types.value("sensor_msgs/msg/CompressedImage", {"data": b"\xff\xd8"})
    read = type(picture).deserialize(picture.serialize(use_version_2=False))
    assert read.data == b"\xff\xd8"
    declared: Any = types.message("sensor_msgs/msg/CompressedImage").declared
    same = declared.deserialize(picture.serialize(use_version_2=False))
    assert list(same.data) == [0xFF, 0xD8]


def test_fields_that_are_left_out_have_their_defaults(tmp_path: Path) -> None:
    folder = tmp_path / "kit_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Kit.msg").write_text(
        "uint8[2] pair\nuint8[] some [3, 4]\nint16[2] two\nint16[] more [5]\nstring<=4 name 'kit'\nstring[<=2] names\n"
        "bool on\nbool[] ons\nInner[2] inner\nfloat64 w 1\n"
    )
    (folder / "Inner.msg").write_text("int32 x 7\n")
    types = TypeMaker(Interfaces(folder=tmp_path))
    made = types.value("kit_msgs/msg/Kit", {"inner": [{"x": 1}, {}], "pair": [8, 9]})
    assert (made.pair, made.some, made.two, made.more) == (b"\x08\x09", b"\x03\x04", [0, 0], [5])
    assert (made.name, made.names, made.on, made.ons, made.w) == ("kit", [], False, [], 1.0)
    assert [each.x for each in made.inner] == [1, 7]
    empty = types.value("kit_msgs/msg/Kit", {})
    assert empty.pair == bytes(2)
    assert [each.x for each in empty.inner] == [7, 7]
    kind = types.message("kit_msgs/msg/Kit")
    data = made.serialize(use_version_2=False)
    assert kind.declared.deserialize(data).serialize(use_version_2=False) == data


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Kit kit", "kit_msgs/msg/Kit contains itself"),
        ("Other other", "kit_msgs/msg/Other is not known"),
        ("int32 from", "the field from is a keyword of Python"),
    ],
)
def test_types_that_cannot_be_made_are_said(text: str, said: str, tmp_path: Path) -> None:
    folder = tmp_path / "kit_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Kit.msg").write_text(text)
    with pytest.raises(DefinitionError, match=said):
        TypeMaker(Interfaces(folder=tmp_path)).message("kit_msgs/msg/Kit")


def test_a_quaternion_that_is_left_out_is_no_turn() -> None:
    made = BOTH["jazzy"].types.value("geometry_msgs/msg/PoseStamped", {})
    turn = made.pose.orientation
    assert math.dist((turn.x, turn.y, turn.z, turn.w), (0, 0, 0, 1)) == 0


def test_requests_begin_with_the_header_of_rmw_cyclonedds() -> None:
    types = BOTH["jazzy"].types
    name = "action_msgs/srv/CancelGoal_Response"
    framed = types.framed(name, 0x0102030405060708, 9, {"return_code": 1}).serialize(use_version_2=False)
    plain = types.value(name, {"return_code": 1}).serialize(use_version_2=False)
    assert framed[:4] == plain[:4]
    assert framed[4:20] == (0x0102030405060708).to_bytes(8, "little") + (9).to_bytes(8, "little")
    # The header is as long as the largest alignment, twice.
    assert framed[20:] == plain[4:]
