"""Every method and notification of the wire with its models: the table that everything else is made of."""

from dataclasses import dataclass
from typing import Final

from pydantic import BaseModel

from openrois.types.access import AuthExpiringNotification, AuthRefreshParams, AuthRefreshResult
from openrois.types.directory import (
    DIRECTORY,
    DirectoryChangedNotification,
    DirectoryListParams,
    DirectoryListResult,
    DirectoryProfilesParams,
    DirectoryProfilesResult,
    DirectoryReadParams,
    DirectoryReadResult,
)
from openrois.types.leases import (
    LeaseBorrowParams,
    LeaseChangedNotification,
    LeaseDeclinedNotification,
    LeaseParams,
    LeaseRequestedNotification,
    LeaseRequestParams,
    LeaseRequestResult,
    LeaseResult,
    LeaseTokenResult,
    LeaseWithdrawnNotification,
    ResumeParams,
    ResumeResult,
    StopAllParams,
    StopAllResult,
)
from openrois.types.messages import (
    CommandResultParams,
    Completed,
    ComponentParams,
    ConditionParams,
    DetailParams,
    ErrorDetailParams,
    ErrorNotification,
    EventNotification,
    ExecuteParams,
    NoParams,
    ParametersResult,
    ProfileResult,
    QueryParams,
    ReferenceResult,
    ResultsResult,
    ReturnResult,
    SearchResult,
    SetParameterParams,
    SetParameterResult,
    SubscribeParams,
    SubscribeResult,
    UnsubscribeParams,
)
from openrois.types.reasons import ReasonNotification
from openrois.types.stops import ReleaseStopParams, StoppedNotification
from openrois.types.streams import (
    ConnectStreamParams,
    ConnectStreamResult,
    EventsDroppedNotification,
    HelloParams,
    HelloResult,
    ReportPlayoutParams,
    SetConsentParams,
    SetConsentResult,
    StreamParams,
    StreamStatusNotification,
    StreamStatusResult,
)

__all__ = ["METHODS", "NOTIFICATIONS", "MethodType", "NotificationType"]


@dataclass(frozen=True, slots=True)
class MethodType:
    """A method that an application calls, and a gateway of its adapters.

    Attributes:
        name: on the wire.
        params: the model of its params.
        result: the model of its result.
        summary: one sentence.
        extension: the extension it belongs to; empty for the base.
    """

    name: str
    params: type[BaseModel]
    result: type[ReturnResult]
    summary: str
    extension: str = ""


@dataclass(frozen=True, slots=True)
class NotificationType:
    """A notification that an engine sends to an application, and an adapter to its gateway.

    Attributes:
        name: on the wire.
        params: the model of its params.
        summary: one sentence.
        extension: the extension it belongs to; empty for the base.
    """

    name: str
    params: type[BaseModel]
    summary: str
    extension: str = ""


METHODS: Final[tuple[MethodType, ...]] = (
    MethodType("rois.system.connect", NoParams, ReturnResult, "Begin a session."),
    MethodType("rois.system.disconnect", NoParams, ReturnResult, "End it: what it has bound and subscribed is free."),
    MethodType("rois.system.get_profile", ConditionParams, ProfileResult, "Ask which engines and components exist."),
    MethodType("rois.system.get_error_detail", ErrorDetailParams, ResultsResult, "Ask more about a fault."),
    MethodType("rois.command.search", ConditionParams, SearchResult, "Ask for the components that meet a condition."),
    MethodType("rois.command.bind", ComponentParams, ReturnResult, "Reserve a component."),
    MethodType("rois.command.bind_any", ConditionParams, ReferenceResult, "Reserve one that meets a condition."),
    MethodType("rois.command.release", ComponentParams, ReturnResult, "Give a component back."),
    MethodType("rois.command.get_parameter", ComponentParams, ParametersResult, "Ask for its parameters."),
    MethodType("rois.command.set_parameter", SetParameterParams, SetParameterResult, "Change its parameters."),
    MethodType("rois.command.execute", ExecuteParams, ReturnResult, "Start a sequence of commands."),
    MethodType("rois.command.get_command_result", CommandResultParams, ResultsResult, "Ask what a command gave."),
    MethodType("rois.query.query", QueryParams, ResultsResult, "Ask a component something."),
    MethodType("rois.event.subscribe", SubscribeParams, SubscribeResult, "Be told of an event."),
    MethodType("rois.event.unsubscribe", UnsubscribeParams, ReturnResult, "Be told of it no more."),
    MethodType("rois.event.get_event_detail", DetailParams, ResultsResult, "Ask what an event tells."),
    MethodType("openrois.hello", HelloParams, HelloResult, "Say and ask which extensions are spoken.", "openrois"),
    MethodType(
        "openrois.auth.refresh",
        AuthRefreshParams,
        AuthRefreshResult,
        "Show a new token before the old one ends.",
        "openrois",
    ),
    MethodType(
        "rois.stream.connect_stream", ConnectStreamParams, ConnectStreamResult, "Connect a stream.", "rois.stream"
    ),
    MethodType("rois.stream.disconnect_stream", StreamParams, ReturnResult, "End a stream.", "rois.stream"),
    MethodType("rois.stream.suspend_stream", StreamParams, ReturnResult, "Pause a stream.", "rois.stream"),
    MethodType("rois.stream.resume_stream", StreamParams, ReturnResult, "Go on with a stream.", "rois.stream"),
    MethodType(
        "rois.stream.query_stream_status", StreamParams, StreamStatusResult, "Ask what a stream does.", "rois.stream"
    ),
    MethodType(
        "rois.stream.report_playout",
        ReportPlayoutParams,
        ReturnResult,
        "Say how long what arrives of a stream waits here until it is played.",
        "rois.stream",
    ),
    MethodType(
        "rois.stream.set_consent",
        SetConsentParams,
        SetConsentResult,
        "Say all that what is sent here may be used for from now on.",
        "rois.stream",
    ),
    MethodType(
        "openrois.directory.list",
        DirectoryListParams,
        DirectoryListResult,
        "Ask which engines there are, page by page.",
        DIRECTORY,
    ),
    MethodType("openrois.directory.read", DirectoryReadParams, DirectoryReadResult, "Ask for some engines.", DIRECTORY),
    MethodType(
        "openrois.directory.profiles",
        DirectoryProfilesParams,
        DirectoryProfilesResult,
        "Ask for the profiles of some components.",
        DIRECTORY,
    ),
    MethodType("openrois.lease.query", LeaseParams, LeaseResult, "Ask who holds a component.", "openrois.lease"),
    MethodType("openrois.lease.request", LeaseParams, LeaseRequestResult, "Ask its holder for it.", "openrois.lease"),
    MethodType("openrois.lease.leave", LeaseParams, ReturnResult, "Wait for it no more.", "openrois.lease"),
    MethodType("openrois.lease.grant", LeaseRequestParams, ReturnResult, "Let who asks have it.", "openrois.lease"),
    MethodType("openrois.lease.decline", LeaseRequestParams, ReturnResult, "Keep it.", "openrois.lease"),
    MethodType(
        "openrois.lease.take",
        LeaseParams,
        LeaseResult,
        "Take it from its holder.",
        "openrois.lease",
    ),
    MethodType("openrois.lease.borrow", LeaseBorrowParams, LeaseResult, "Take it for a time.", "openrois.lease"),
    MethodType("openrois.lease.give_back", LeaseParams, ReturnResult, "Give its part back.", "openrois.lease"),
    MethodType("openrois.lease.token", NoParams, LeaseTokenResult, "Ask for a resume token.", "openrois.lease"),
    MethodType("openrois.lease.resume", ResumeParams, ResumeResult, "Go on with a lost session.", "openrois.lease"),
    MethodType("openrois.stop_all", StopAllParams, StopAllResult, "Stop all that acts on an engine.", "openrois.lease"),
    MethodType(
        "openrois.lease.release_stop",
        ReleaseStopParams,
        ReturnResult,
        "Hand what a person has stopped back to programs.",
        "openrois.lease",
    ),
)
"""The base in the order of the standard, then the extensions; `signaling.*` stands in `openrois_signaling`."""

NOTIFICATIONS: Final[tuple[NotificationType, ...]] = (
    NotificationType("rois.system.notify_error", ErrorNotification, "An engine or a component has a fault."),
    NotificationType("rois.system.profile_changed", NoParams, "The engines or components are others now."),
    NotificationType("rois.command.completed", Completed, "A command has ended."),
    NotificationType("rois.event.notify_event", EventNotification, "An event happened."),
    NotificationType(
        EventsDroppedNotification.method,
        EventsDroppedNotification,
        "Here some events and errors were dropped: the application reads too slowly.",
        "openrois",
    ),
    NotificationType(
        AuthExpiringNotification.method,
        AuthExpiringNotification,
        "The token ends soon, and the connection with it.",
        "openrois",
    ),
    NotificationType(
        ReasonNotification.method,
        ReasonNotification,
        "Why the message right behind this one, a reply or `completed`, says something else than OK.",
        "openrois",
    ),
    NotificationType(
        StreamStatusNotification.method, StreamStatusNotification, "A stream does something else now.", "rois.stream"
    ),
    NotificationType(
        DirectoryChangedNotification.method,
        DirectoryChangedNotification,
        "Engines came, changed or have gone; in the place of `rois.system.profile_changed`.",
        DIRECTORY,
    ),
    NotificationType(
        LeaseChangedNotification.method,
        LeaseChangedNotification,
        "A component has another holder, or another queue.",
        "openrois.lease",
    ),
    NotificationType(
        LeaseRequestedNotification.method,
        LeaseRequestedNotification,
        "Another application asks for a component that this one holds.",
        "openrois.lease",
    ),
    NotificationType(
        LeaseDeclinedNotification.method,
        LeaseDeclinedNotification,
        "The holder keeps the component, or does not answer.",
        "openrois.lease",
    ),
    NotificationType(
        LeaseWithdrawnNotification.method,
        LeaseWithdrawnNotification,
        "Who has asked for the component does not any more.",
        "openrois.lease",
    ),
    NotificationType(
        StoppedNotification.method,
        StoppedNotification,
        "A person has stopped an engine for programs, or handed it back.",
        "openrois.lease",
    ),
)
