"""What one subject may have over all of its connections."""

from contextlib import ExitStack

import pytest

from openrois.auth.subject_quotas import SubjectQuotas
from openrois.errors import OutOfResources
from tests.support.quotas import Session


def test_connections_are_counted_for_each_subject() -> None:
    quotas = SubjectQuotas(connections=2, sessions=4)
    with quotas.connected("a"), quotas.connected("a"), quotas.connected("b"):
        assert (quotas.most_connections, quotas.most_sessions) == (2, 2)
        with pytest.raises(OutOfResources, match="at most 2 connections"), quotas.connected("a"):
            pass
    assert quotas.most_connections == 0
    with quotas.connected("a"):
        pass


def test_sessions_that_may_be_resumed_count() -> None:
    quotas, absent = SubjectQuotas(connections=2, sessions=3), [Session("a"), Session("a"), Session("b")]
    quotas.absent = lambda: absent
    with quotas.connected("a"):
        assert quotas.most_sessions == 3
        with pytest.raises(OutOfResources, match="at most 3 sessions"), quotas.connected("a"):
            pass
        with quotas.connected("b"):
            pass
        absent.pop(0)
        with quotas.connected("a"):
            pass


def test_streams_are_counted_with_those_that_are_being_connected() -> None:
    quotas, sessions = SubjectQuotas(streams=3), [Session("a", ["1"]), Session("a", connecting=1), Session("b", ["2"])]
    with ExitStack() as stack:
        for session in sessions:
            stack.enter_context(quotas.serving(session))
        for session in sessions:
            quotas.require_stream(session)
        sessions[1].streams.append("3")
        assert quotas.most_streams == 3
        for session in sessions[:2]:
            with pytest.raises(OutOfResources, match="at most 3 streams"):
                quotas.require_stream(session)
        quotas.require_stream(sessions[2])
        sessions[0].streams.clear()
        quotas.require_stream(sessions[1])
    assert quotas.most_streams == 0
