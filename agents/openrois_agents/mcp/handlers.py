"""What the server does with each request: tools and documents of a caller's session."""

from collections.abc import Awaitable, Callable
from typing import Any, Final, Protocol
from weakref import WeakKeyDictionary

from mcp.server.context import ServerRequestContext
from mcp.shared.exceptions import MCPError
from mcp_types import (
    INVALID_PARAMS,
    CallToolRequestParams,
    CallToolResult,
    EmptyResult,
    ListResourcesResult,
    ListResourceTemplatesResult,
    ListToolsResult,
    PaginatedRequestParams,
    ReadResourceRequestParams,
    ReadResourceResult,
    Resource,
    ResourceTemplate,
    SubscribeRequestParams,
    SubscriptionsListenRequestParams,
    SubscriptionsListenResult,
    TextResourceContents,
    Tool,
    ToolAnnotations,
    UnsubscribeRequestParams,
)
from mcp_types.version import HANDSHAKE_PROTOCOL_VERSIONS

from openrois.client import ConnectionFailed
from openrois_agents.mcp.announcements import Announcements
from openrois_agents.mcp.results import answered, failed
from openrois_agents.tools.documents import BODIES, EVENTS, PROFILE, profile_address, read_document
from openrois_agents.tools.failures import FAILURES, failure
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.session import Session
from openrois_agents.tools.toolbox import TOOLS, call_tool, input_schema

__all__ = ["Handlers", "SessionFinder"]

_JSON: Final = "application/json"
_TEXT: Final = "text/plain"
_PROFILE: Final = "All messages of a body's components"

Context = ServerRequestContext[Any, Any]


class SessionFinder(Protocol):
    """Finds the session of a caller."""

    async def find_session(self, request: Any) -> Session:
        """Return the session of the caller that sent a request over HTTP; `request` is None on standard input.

        Raises:
            ConnectionFailed: the gateway does not let the caller in.
        """
        ...


class Handlers:
    """Handles the requests of hosts.

    Args:
        finder: finds the session that a request belongs to.
    """

    def __init__(self, finder: SessionFinder) -> None:
        self._finder = finder
        self._announcements: WeakKeyDictionary[Session, Announcements] = WeakKeyDictionary()

    async def list_tools(self, context: Context, _params: PaginatedRequestParams | None) -> ListToolsResult:
        """List the tools, with the names that can be chosen where the gateway tells them."""
        vocabulary = await self._vocabulary(context)
        return ListToolsResult(
            tools=[
                Tool(
                    name=name,
                    description=tool.description,
                    input_schema=input_schema(tool, vocabulary),
                    annotations=ToolAnnotations(read_only_hint=tool.reads_only, destructive_hint=False),
                )
                for name, tool in TOOLS.items()
            ]
        )

    def find_schema(self, name: str) -> dict[str, Any] | None:
        """Return the schema of a tool's arguments without names that change: the library looks for headers in it."""
        return input_schema(TOOLS[name], Vocabulary()) if name in TOOLS else None

    async def call_tool(self, context: Context, params: CallToolRequestParams) -> CallToolResult:
        """Call a tool; what it fails with is a result that says so."""
        if params.name not in TOOLS:
            raise MCPError(INVALID_PARAMS, f"there is no tool {params.name!r}: there are {', '.join(TOOLS)}")
        try:
            session = await self._finder.find_session(context.request)
            return answered(await call_tool(session, params.name, params.arguments, _progress(context)))
        except Exception as error:
            return failed(*failure(params.name, error))

    async def list_resources(self, context: Context, _params: PaginatedRequestParams | None) -> ListResourcesResult:
        """List the documents, with the profile of each body where the gateway tells them."""
        bodies = (await self._vocabulary(context)).bodies
        profiles = [
            Resource(uri=profile_address(body), name=f"profile of {body}", description=_PROFILE, mime_type=_JSON)
            for body in bodies
        ]
        return ListResourcesResult(
            resources=[
                Resource(uri=BODIES, name="bodies", description="The bodies, and what acts on them", mime_type=_JSON),
                Resource(uri=EVENTS, name="events", description="What happened: the last events", mime_type=_TEXT),
                *profiles,
            ]
        )

    async def list_resource_templates(
        self, _context: Context, _params: PaginatedRequestParams | None
    ) -> ListResourceTemplatesResult:
        """List the addresses of profiles."""
        profile = ResourceTemplate(uri_template=PROFILE, name="profile", description=_PROFILE, mime_type=_JSON)
        return ListResourceTemplatesResult(resource_templates=[profile])

    async def read_resource(self, context: Context, params: ReadResourceRequestParams) -> ReadResourceResult:
        """Read a document."""
        try:
            session = await self._finder.find_session(context.request)
            text = await read_document(session, params.uri)
        except Exception as error:
            raise MCPError(INVALID_PARAMS, failure("read", error)[1]) from None
        kind = _TEXT if params.uri == EVENTS else _JSON
        return ReadResourceResult(contents=[TextResourceContents(uri=params.uri, mime_type=kind, text=text)])

    async def subscribe(self, context: Context, params: SubscribeRequestParams) -> EmptyResult:
        """Tell a host of the older generation when a document changes."""
        session = await self._found(context)
        self._announcing(session).subscribe(context.session, params.uri)
        return EmptyResult()

    async def unsubscribe(self, context: Context, params: UnsubscribeRequestParams) -> EmptyResult:
        """Tell of a document no more."""
        session = await self._found(context)
        self._announcing(session).unsubscribe(params.uri)
        return EmptyResult()

    async def listen(self, context: Context, params: SubscriptionsListenRequestParams) -> SubscriptionsListenResult:
        """Serve a stream of changes to a host of the newer generation."""
        session = await self._found(context)
        return await self._announcing(session).listen(context, params)

    async def _vocabulary(self, context: Context) -> Vocabulary:
        """Return the names that can be chosen; none where the gateway does not tell, as each call of a tool says then.

        A host of the older generation is told from then on when they change; one of the newer asks for that.
        """
        try:
            session = await self._finder.find_session(context.request)
            if context.protocol_version in HANDSHAKE_PROTOCOL_VERSIONS:
                self._announcing(session).add_connection(context.session)
            return await session.vocabulary()
        except FAILURES:
            return Vocabulary()

    async def _found(self, context: Context) -> Session:
        """Return the caller's session.

        Raises:
            MCPError: the gateway does not let the caller in.
        """
        try:
            return await self._finder.find_session(context.request)
        except ConnectionFailed as error:
            raise MCPError(INVALID_PARAMS, failure("listen", error)[1]) from None

    def _announcing(self, session: Session) -> Announcements:
        if session not in self._announcements:
            self._announcements[session] = Announcements(session)
        return self._announcements[session]


def _progress(context: Context) -> Callable[[float, str], Awaitable[None]]:
    """Return what reports the progress of a call to its host."""

    async def report(seconds: float, message: str) -> None:
        await context.session.report_progress(seconds, None, message)

    return report
