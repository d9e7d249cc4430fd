"""Answering for a command of a former run of the gateway, which the journal knows."""

from openrois.errors import RoISError
from openrois.jsonrpc.session import Reply
from openrois.session.session import ApplicationSession
from openrois.types.messages import ResultsResult

__all__ = ["former_command"]


def former_command(app: ApplicationSession, command_id: str) -> Reply | None:
    """Return the reply of `get_command_result`, or None where the journal knows no such command of this principal's.

    How the command ended is told right behind the reply, if that has not been told before.
    """
    journal, subject = app.host.journal, app.principal.subject
    former = journal.find(subject, command_id)
    if former is None or not app.principal.sees(former.component_ref):
        return None
    told = journal.tell(subject, command_id)
    then = None if told is None else lambda: app.completed(command_id, former.end, former.reason)
    try:
        return Reply(ResultsResult(results=former.results()), then)
    except RoISError as error:
        return Reply(ResultsResult(return_code=error.return_code), then, str(error))
