// Methods and notifications of the wire. Written by `make generate`; edits are lost.
namespace OpenRoIS
{
    /// <summary>What an application may call.</summary>
    public static class Methods
    {
        /// <summary>Begin a session.</summary>
        public static readonly Method<NoParams, ReturnResult> SystemConnect =
            new Method<NoParams, ReturnResult>("rois.system.connect");
        /// <summary>End it: what it has bound and subscribed is free.</summary>
        public static readonly Method<NoParams, ReturnResult> SystemDisconnect =
            new Method<NoParams, ReturnResult>("rois.system.disconnect");
        /// <summary>Ask which engines and components exist.</summary>
        public static readonly Method<ConditionParams, ProfileResult> SystemGetProfile =
            new Method<ConditionParams, ProfileResult>("rois.system.get_profile");
        /// <summary>Ask more about a fault.</summary>
        public static readonly Method<ErrorDetailParams, ResultsResult> SystemGetErrorDetail =
            new Method<ErrorDetailParams, ResultsResult>("rois.system.get_error_detail");
        /// <summary>Ask for the components that meet a condition.</summary>
        public static readonly Method<ConditionParams, SearchResult> CommandSearch =
            new Method<ConditionParams, SearchResult>("rois.command.search");
        /// <summary>Reserve a component.</summary>
        public static readonly Method<ComponentParams, ReturnResult> CommandBind =
            new Method<ComponentParams, ReturnResult>("rois.command.bind");
        /// <summary>Reserve one that meets a condition.</summary>
        public static readonly Method<ConditionParams, ReferenceResult> CommandBindAny =
            new Method<ConditionParams, ReferenceResult>("rois.command.bind_any");
        /// <summary>Give a component back.</summary>
        public static readonly Method<ComponentParams, ReturnResult> CommandRelease =
            new Method<ComponentParams, ReturnResult>("rois.command.release");
        /// <summary>Ask for its parameters.</summary>
        public static readonly Method<ComponentParams, ParametersResult> CommandGetParameter =
            new Method<ComponentParams, ParametersResult>("rois.command.get_parameter");
        /// <summary>Change its parameters.</summary>
        public static readonly Method<SetParameterParams, SetParameterResult> CommandSetParameter =
            new Method<SetParameterParams, SetParameterResult>("rois.command.set_parameter");
        /// <summary>Start a sequence of commands.</summary>
        public static readonly Method<ExecuteParams, ReturnResult> CommandExecute =
            new Method<ExecuteParams, ReturnResult>("rois.command.execute");
        /// <summary>Ask what a command gave.</summary>
        public static readonly Method<CommandResultParams, ResultsResult> CommandGetCommandResult =
            new Method<CommandResultParams, ResultsResult>("rois.command.get_command_result");
        /// <summary>Ask a component something.</summary>
        public static readonly Method<QueryParams, ResultsResult> QueryQuery =
            new Method<QueryParams, ResultsResult>("rois.query.query");
        /// <summary>Be told of an event.</summary>
        public static readonly Method<SubscribeParams, SubscribeResult> EventSubscribe =
            new Method<SubscribeParams, SubscribeResult>("rois.event.subscribe");
        /// <summary>Be told of it no more.</summary>
        public static readonly Method<UnsubscribeParams, ReturnResult> EventUnsubscribe =
            new Method<UnsubscribeParams, ReturnResult>("rois.event.unsubscribe");
        /// <summary>Ask what an event tells.</summary>
        public static readonly Method<DetailParams, ResultsResult> EventGetEventDetail =
            new Method<DetailParams, ResultsResult>("rois.event.get_event_detail");
        /// <summary>Say and ask which extensions are spoken.</summary>
        public static readonly Method<HelloParams, HelloResult> Hello =
            new Method<HelloParams, HelloResult>("openrois.hello");
        /// <summary>Show a new token before the old one ends.</summary>
        public static readonly Method<AuthRefreshParams, AuthRefreshResult> AuthRefresh =
            new Method<AuthRefreshParams, AuthRefreshResult>("openrois.auth.refresh");
        /// <summary>Connect a stream.</summary>
        public static readonly Method<ConnectStreamParams, ConnectStreamResult> StreamConnectStream =
            new Method<ConnectStreamParams, ConnectStreamResult>("rois.stream.connect_stream");
        /// <summary>End a stream.</summary>
        public static readonly Method<StreamParams, ReturnResult> StreamDisconnectStream =
            new Method<StreamParams, ReturnResult>("rois.stream.disconnect_stream");
        /// <summary>Pause a stream.</summary>
        public static readonly Method<StreamParams, ReturnResult> StreamSuspendStream =
            new Method<StreamParams, ReturnResult>("rois.stream.suspend_stream");
        /// <summary>Go on with a stream.</summary>
        public static readonly Method<StreamParams, ReturnResult> StreamResumeStream =
            new Method<StreamParams, ReturnResult>("rois.stream.resume_stream");
        /// <summary>Ask what a stream does.</summary>
        public static readonly Method<StreamParams, StreamStatusResult> StreamQueryStreamStatus =
            new Method<StreamParams, StreamStatusResult>("rois.stream.query_stream_status");
        /// <summary>Say how long what arrives of a stream waits here until it is played.</summary>
        public static readonly Method<ReportPlayoutParams, ReturnResult> StreamReportPlayout =
            new Method<ReportPlayoutParams, ReturnResult>("rois.stream.report_playout");
        /// <summary>Say all that what is sent here may be used for from now on.</summary>
        public static readonly Method<SetConsentParams, SetConsentResult> StreamSetConsent =
            new Method<SetConsentParams, SetConsentResult>("rois.stream.set_consent");
        /// <summary>Ask which engines there are, page by page.</summary>
        public static readonly Method<DirectoryListParams, DirectoryListResult> DirectoryList =
            new Method<DirectoryListParams, DirectoryListResult>("openrois.directory.list");
        /// <summary>Ask for some engines.</summary>
        public static readonly Method<DirectoryReadParams, DirectoryReadResult> DirectoryRead =
            new Method<DirectoryReadParams, DirectoryReadResult>("openrois.directory.read");
        /// <summary>Ask for the profiles of some components.</summary>
        public static readonly Method<DirectoryProfilesParams, DirectoryProfilesResult> DirectoryProfiles =
            new Method<DirectoryProfilesParams, DirectoryProfilesResult>("openrois.directory.profiles");
        /// <summary>Ask who holds a component.</summary>
        public static readonly Method<LeaseParams, LeaseResult> LeaseQuery =
            new Method<LeaseParams, LeaseResult>("openrois.lease.query");
        /// <summary>Ask its holder for it.</summary>
        public static readonly Method<LeaseParams, LeaseRequestResult> LeaseRequest =
            new Method<LeaseParams, LeaseRequestResult>("openrois.lease.request");
        /// <summary>Wait for it no more.</summary>
        public static readonly Method<LeaseParams, ReturnResult> LeaseLeave =
            new Method<LeaseParams, ReturnResult>("openrois.lease.leave");
        /// <summary>Let who asks have it.</summary>
        public static readonly Method<LeaseRequestParams, ReturnResult> LeaseGrant =
            new Method<LeaseRequestParams, ReturnResult>("openrois.lease.grant");
        /// <summary>Keep it.</summary>
        public static readonly Method<LeaseRequestParams, ReturnResult> LeaseDecline =
            new Method<LeaseRequestParams, ReturnResult>("openrois.lease.decline");
        /// <summary>Take it from its holder.</summary>
        public static readonly Method<LeaseParams, LeaseResult> LeaseTake =
            new Method<LeaseParams, LeaseResult>("openrois.lease.take");
        /// <summary>Take it for a time.</summary>
        public static readonly Method<LeaseBorrowParams, LeaseResult> LeaseBorrow =
            new Method<LeaseBorrowParams, LeaseResult>("openrois.lease.borrow");
        /// <summary>Give its part back.</summary>
        public static readonly Method<LeaseParams, ReturnResult> LeaseGiveBack =
            new Method<LeaseParams, ReturnResult>("openrois.lease.give_back");
        /// <summary>Ask for a resume token.</summary>
        public static readonly Method<NoParams, LeaseTokenResult> LeaseToken =
            new Method<NoParams, LeaseTokenResult>("openrois.lease.token");
        /// <summary>Go on with a lost session.</summary>
        public static readonly Method<ResumeParams, ResumeResult> LeaseResume =
            new Method<ResumeParams, ResumeResult>("openrois.lease.resume");
        /// <summary>Stop all that acts on an engine.</summary>
        public static readonly Method<StopAllParams, StopAllResult> StopAll =
            new Method<StopAllParams, StopAllResult>("openrois.stop_all");
        /// <summary>Hand what a person has stopped back to programs.</summary>
        public static readonly Method<ReleaseStopParams, ReturnResult> LeaseReleaseStop =
            new Method<ReleaseStopParams, ReturnResult>("openrois.lease.release_stop");
        /// <summary>Answer an engine's offer.</summary>
        public static readonly Method<Answer, ReturnResult> SignalingAnswer =
            new Method<Answer, ReturnResult>("signaling.answer");
        /// <summary>Tell an engine of a candidate.</summary>
        public static readonly Method<Candidate, ReturnResult> SignalingCandidate =
            new Method<Candidate, ReturnResult>("signaling.candidate");
        /// <summary>Ask for a new peer connection.</summary>
        public static readonly Method<Restart, ReturnResult> SignalingRestart =
            new Method<Restart, ReturnResult>("signaling.restart");
        /// <summary>Ask which servers help to connect.</summary>
        public static readonly Method<NoParams, IceServersResult> SignalingIceServers =
            new Method<NoParams, IceServersResult>("signaling.ice_servers");
    }

    /// <summary>What an application may be told.</summary>
    public static class Notifications
    {
        /// <summary>An engine or a component has a fault.</summary>
        public static readonly Notification<ErrorNotification> SystemNotifyError =
            new Notification<ErrorNotification>("rois.system.notify_error");
        /// <summary>The engines or components are others now.</summary>
        public static readonly Notification<NoParams> SystemProfileChanged =
            new Notification<NoParams>("rois.system.profile_changed");
        /// <summary>A command has ended.</summary>
        public static readonly Notification<Completed> CommandCompleted =
            new Notification<Completed>("rois.command.completed");
        /// <summary>An event happened.</summary>
        public static readonly Notification<EventNotification> EventNotifyEvent =
            new Notification<EventNotification>("rois.event.notify_event");
        /// <summary>Here some events and errors were dropped: the application reads too slowly.</summary>
        public static readonly Notification<EventsDroppedNotification> EventsDropped =
            new Notification<EventsDroppedNotification>("openrois.events_dropped");
        /// <summary>The token ends soon, and the connection with it.</summary>
        public static readonly Notification<AuthExpiringNotification> AuthExpiring =
            new Notification<AuthExpiringNotification>("openrois.auth.expiring");
        /// <summary>
        /// Why the message right behind this one, a reply or <c>completed</c>, says something else than OK.
        /// </summary>
        public static readonly Notification<ReasonNotification> Reason =
            new Notification<ReasonNotification>("openrois.reason");
        /// <summary>A stream does something else now.</summary>
        public static readonly Notification<StreamStatusNotification> StreamNotifyStreamStatus =
            new Notification<StreamStatusNotification>("rois.stream.notify_stream_status");
        /// <summary>Engines came, changed or have gone; in the place of <c>rois.system.profile_changed</c>.</summary>
        public static readonly Notification<DirectoryChangedNotification> DirectoryChanged =
            new Notification<DirectoryChangedNotification>("openrois.directory.changed");
        /// <summary>A component has another holder, or another queue.</summary>
        public static readonly Notification<LeaseChangedNotification> LeaseChanged =
            new Notification<LeaseChangedNotification>("openrois.lease.changed");
        /// <summary>Another application asks for a component that this one holds.</summary>
        public static readonly Notification<LeaseRequestedNotification> LeaseRequested =
            new Notification<LeaseRequestedNotification>("openrois.lease.requested");
        /// <summary>The holder keeps the component, or does not answer.</summary>
        public static readonly Notification<LeaseDeclinedNotification> LeaseDeclined =
            new Notification<LeaseDeclinedNotification>("openrois.lease.declined");
        /// <summary>Who has asked for the component does not any more.</summary>
        public static readonly Notification<LeaseWithdrawnNotification> LeaseWithdrawn =
            new Notification<LeaseWithdrawnNotification>("openrois.lease.withdrawn");
        /// <summary>A person has stopped an engine for programs, or handed it back.</summary>
        public static readonly Notification<StoppedNotification> LeaseStopped =
            new Notification<StoppedNotification>("openrois.lease.stopped");
        /// <summary>An engine offers a peer connection.</summary>
        public static readonly Notification<Offer> SignalingOffer =
            new Notification<Offer>("signaling.offer");
        /// <summary>An engine has a candidate.</summary>
        public static readonly Notification<Candidate> SignalingCandidate =
            new Notification<Candidate>("signaling.candidate");
        /// <summary>An engine says when what it sends was captured.</summary>
        public static readonly Notification<CaptureClocks> SignalingCaptureClocks =
            new Notification<CaptureClocks>("signaling.capture_clocks");
        /// <summary>An engine has ended a peer connection.</summary>
        public static readonly Notification<Bye> SignalingBye =
            new Notification<Bye>("signaling.bye");
    }
}
