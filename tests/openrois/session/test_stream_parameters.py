"""What an application sees of a streaming component's parameters."""

from openrois.session.stream_parameters import StreamParameters, lost_streams
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, ParameterProfile, RoISIdentifier

CAMERA = "robot/camera"
PROFILE = HRIComponentProfile(
    identifier=RoISIdentifier(code="urn:camera"),
    name="camera",
    parameter_profiles=(ParameterProfile(name="encoding_parameters", data_type_ref=RoISIdentifier(code="String")),),
)


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="any", value=value)


def stored(**values: str) -> list[Result]:
    return [Result(name=name, data_type_ref="String", value=value) for name, value in values.items()]


def seen(parameters: StreamParameters, *results: Result, ref: str = CAMERA) -> dict[str, tuple[str, str]]:
    return {p.name: (p.data_type_ref, p.value) for p in parameters.over(ref, results)}


def test_what_was_set_stands_over_what_is_stored() -> None:
    parameters = StreamParameters()
    common = stored(available_encodings="all", encoding_parameters="shared")
    assert seen(parameters, *common) == {
        "available_encodings": ("String", "all"),
        "encoding_parameters": ("String", "shared"),
    }
    parameters.keep(CAMERA, PROFILE, [argument("encoding_parameters", "mine"), argument("unheard_of", "x")])
    assert seen(parameters, *common) == {
        "available_encodings": ("String", "all"),
        "encoding_parameters": ("String", "mine"),
        "unheard_of": ("any", "x"),
    }
    parameters.keep(CAMERA, PROFILE, [argument("encoding_parameters", ""), argument("unheard_of", "")])
    assert seen(parameters, *common) == {"available_encodings": ("String", "all")}


def test_it_is_of_one_component_and_forgotten_with_it() -> None:
    parameters = StreamParameters()
    parameters.keep(CAMERA, PROFILE, [argument("encoding_parameters", "mine")])
    assert seen(parameters, ref="robot/other") == {}
    parameters.keep_only({CAMERA})
    assert seen(parameters) == {"encoding_parameters": ("String", "mine")}
    parameters.keep_only({"robot/other"})
    assert seen(parameters) == {}


def test_streams_of_components_that_are_gone() -> None:
    (notice,) = lost_streams({"a/1": "a/camera", "b/1": "b/camera"}, {"a/camera"}, 0.0)
    assert notice.model_dump(mode="json") == {
        "stream_id": "b/1",
        "component_ref": "b/camera",
        "status": "STREAMING_NOT_CONNECTED",
        "timestamp": "1970-01-01T00:00:00.000000+00:00",
    }
