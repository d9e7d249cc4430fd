"""The RoIS interfaces as method tables over one `ApplicationSession`: thin, one module each."""

from openrois.interfaces import command, directory, event, lease, query, stop, stream, system
from openrois.interfaces.directory import DirectoryReader
from openrois.jsonrpc.method_tables import BoundMethods
from openrois.session.session import ApplicationSession

__all__ = ["base_methods", "directory_methods", "lease_methods", "stream_methods"]


def base_methods(app: ApplicationSession) -> BoundMethods:
    """Return the operations of the base wire; what is not in it answers -32601."""
    return system.methods(app).before(command.methods(app), query.methods(app), event.methods(app))


def stream_methods(app: ApplicationSession) -> BoundMethods:
    """Return `openrois.hello` and the streaming verbs for an application."""
    return stream.methods(app)


def directory_methods(reader: DirectoryReader) -> BoundMethods:
    """Return `openrois.directory.*` for an application."""
    return directory.methods(reader)


def lease_methods(app: ApplicationSession) -> BoundMethods:
    """Return `openrois.lease.*` and `openrois.stop_all` for an application."""
    return lease.methods(app).before(stop.methods(app))
