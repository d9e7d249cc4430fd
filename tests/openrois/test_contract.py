"""An event as text: what a model would have written, for any text in it."""

import json

from hypothesis import given
from hypothesis import strategies as st

from openrois.contract import Event
from openrois.types.messages import EventNotification, Result


@given(st.text(), st.text(), st.text(), st.text(), st.lists(st.tuples(st.text(), st.text(), st.text()), max_size=3))
def test_it_reads_as_the_notification(
    event_id: str, event_type: str, expire: str, subscribe_id: str, texts: list[tuple[str, str, str]]
) -> None:
    results = tuple(Result(name=name, data_type_ref=kind, value=value) for name, kind, value in texts)
    event = Event(event_id, event_type, "robot/bell", expire, results)
    told = EventNotification(
        event_id=event_id, event_type=event_type, subscribe_id=subscribe_id, expire=expire, results=results
    )
    text = event.text.params_for(json.dumps(subscribe_id))
    text.encode()
    assert json.loads(text) == told.model_dump(mode="json")
    assert event.text is event.text
    assert event.text.results() == results


def test_half_a_surrogate_pair_passes() -> None:
    event = Event("e\ud800", "rang", "robot/bell", "", ())
    assert json.loads(event.text.params_for('"s"'))["event_id"] == "e\ud800"
