"""Who announces the end of a stream whose engine is gone."""

from openrois.contract import Directory
from openrois.session.lost_streams import lost_streams
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier


def test_streams_of_components_that_are_gone() -> None:
    profile = HRIComponentProfile(identifier=RoISIdentifier(code="urn"), name="camera")
    directory = Directory(HRIEngineProfile(identifier=RoISIdentifier(code="g")), {"a/camera": profile})
    (notice,) = lost_streams({"a/1": "a/camera", "b/1": "b/camera"}, directory, 0.0)
    assert notice.model_dump(mode="json") == {
        "stream_id": "b/1",
        "component_ref": "b/camera",
        "status": "STREAMING_NOT_CONNECTED",
        "timestamp": "1970-01-01T00:00:00.000000+00:00",
    }
