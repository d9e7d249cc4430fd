// Types of the wire. Written by `make generate`; edits are lost.
using System;
using System.Collections.Generic;
using System.Runtime.Serialization;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>The application's description for the offer of the same generation.</summary>
    public sealed class Answer
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }

        [JsonProperty("generation", Required = Required.Always)]
        public int Generation { get; set; }

        [JsonProperty("sdp", Required = Required.Always)]
        public string Sdp { get; set; }
    }

    /// <summary>An argument of a command.</summary>
    public sealed class Argument
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("data_type_ref", Required = Required.Always)]
        public string DataTypeRef { get; set; }

        [JsonProperty("value", Required = Required.Always)]
        public string Value { get; set; }
    }

    /// <summary>
    /// Params of the notification <c>openrois.auth.expiring</c>: in how many seconds the connection will be
    /// closed.
    /// </summary>
    public sealed class AuthExpiringNotification
    {
        [JsonProperty("seconds", Required = Required.Always)]
        public long Seconds { get; set; }
    }

    /// <summary>
    /// Params of <c>openrois.auth.refresh</c>: a token of the same subject, from now on in place of the
    /// present one.
    /// </summary>
    public sealed class AuthRefreshParams
    {
        [JsonProperty("token", Required = Required.Always)]
        public string Token { get; set; }
    }

    /// <summary>Result of <c>openrois.auth.refresh</c>: for how many seconds the connection may now go on.</summary>
    public sealed class AuthRefreshResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("seconds")]
        public long Seconds { get; set; } = 0;
    }

    /// <summary>The deliberate end of a peer connection; <c>reason</c> is a sentence for a person.</summary>
    public sealed class Bye
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }

        [JsonProperty("reason", Required = Required.Always)]
        public string Reason { get; set; }
    }

    /// <summary>One ICE candidate of the sender, belonging to the description of <c>generation</c>.</summary>
    public sealed class Candidate
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }

        [JsonProperty("generation", Required = Required.Always)]
        public int Generation { get; set; }

        [JsonProperty("candidate", Required = Required.AllowNull)]
        [JsonConverter(typeof(TextOrNullConverter))]
        public string CandidateValue { get; set; }

        [JsonProperty("sdp_mid", NullValueHandling = NullValueHandling.Ignore)]
        public string SdpMid { get; set; }

        [JsonProperty("sdp_m_line_index", NullValueHandling = NullValueHandling.Ignore)]
        public int? SdpMLineIndex { get; set; }
    }

    /// <summary>
    /// The clocks of the senders of a peer connection, each by the m-section and the SSRC that it sends
    /// with.
    /// </summary>
    public sealed class CaptureClocks
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }

        [JsonProperty("senders", Required = Required.Always)]
        public List<SenderClock> Senders { get; set; } = new List<SenderClock>();
    }

    /// <summary>
    /// A command: what it takes, what <c>get_command_result</c> gives, and the milliseconds it may take.
    /// </summary>
    public sealed class CommandMessageProfile
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("results")]
        public List<ParameterProfile> Results { get; set; } = new List<ParameterProfile>();

        [JsonProperty("arguments")]
        public List<ParameterProfile> Arguments { get; set; } = new List<ParameterProfile>();

        [JsonProperty("timeout", NullValueHandling = NullValueHandling.Ignore)]
        public long? Timeout { get; set; }
    }

    /// <summary>Params of get_command_result.</summary>
    public sealed class CommandResultParams
    {
        [JsonProperty("command_id", Required = Required.Always)]
        public string CommandId { get; set; }

        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>One command. <c>delay_time</c> is the milliseconds between its turn and its start.</summary>
    public sealed class CommandUnit : ISequenceItem
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("command_type", Required = Required.Always)]
        public string CommandType { get; set; }

        [JsonProperty("command_id", Required = Required.Always)]
        public string CommandId { get; set; }

        [JsonProperty("arguments")]
        public List<Argument> Arguments { get; set; } = new List<Argument>();

        [JsonProperty("delay_time", NullValueHandling = NullValueHandling.Ignore)]
        public int? DelayTime { get; set; }
    }

    /// <summary>Notification: a command has ended, sent exactly once.</summary>
    public sealed class Completed
    {
        [JsonProperty("command_id", Required = Required.Always)]
        public string CommandId { get; set; }

        [JsonProperty("status", Required = Required.Always)]
        public CompletedStatus Status { get; set; }
    }

    /// <summary>How a command ended (RoIS_Service::Completed_Status).</summary>
    public enum CompletedStatus
    {
        [EnumMember(Value = "OK")]
        Ok,
        [EnumMember(Value = "ERROR")]
        Error,
        [EnumMember(Value = "ABORT")]
        Abort,
        [EnumMember(Value = "OUT_OF_RESOURCES")]
        OutOfResources,
        [EnumMember(Value = "TIMEOUT")]
        Timeout,
    }

    /// <summary>A component in short.</summary>
    public sealed class ComponentEntry
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("component_type", Required = Required.Always)]
        public string ComponentType { get; set; }

        [JsonProperty("function", NullValueHandling = NullValueHandling.Ignore)]
        public ComponentFunction? Function { get; set; }

        [JsonProperty("profile_version", Required = Required.Always)]
        public string ProfileVersion { get; set; }
    }

    /// <summary>
    /// The class of a component: only an actuation has to be bound before it is operated. An extension of
    /// the wire.
    /// </summary>
    public enum ComponentFunction
    {
        [EnumMember(Value = "actuation")]
        Actuation,
        [EnumMember(Value = "sensing")]
        Sensing,
        [EnumMember(Value = "function")]
        Function,
    }

    /// <summary>Params of bind, release and get_parameter.</summary>
    public sealed class ComponentParams
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }
    }

    /// <summary>What a component is able to do now (RoIS_Common::Component_Status).</summary>
    public enum ComponentStatus
    {
        [EnumMember(Value = "UNINITIALIZED")]
        Uninitialized,
        [EnumMember(Value = "READY")]
        Ready,
        [EnumMember(Value = "BUSY")]
        Busy,
        [EnumMember(Value = "WARNING")]
        Warning,
        [EnumMember(Value = "ERROR")]
        Error,
    }

    /// <summary>Commands that run at the same time; the next item of the sequence waits for all of them.</summary>
    public sealed class ConcurrentCommands : ISequenceItem
    {
        [JsonProperty("command_list", Required = Required.Always)]
        public List<CommandUnit> CommandList { get; set; } = new List<CommandUnit>();

        [JsonProperty("delay_time", NullValueHandling = NullValueHandling.Ignore)]
        public int? DelayTime { get; set; }
    }

    /// <summary>Params of get_profile, search and bind_any: a condition, empty for everything.</summary>
    public sealed class ConditionParams
    {
        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>
    /// Params of connect_stream; parameters are <c>encoding_parameters</c> and <c>transport_parameters</c>,
    /// JSON text each.
    /// </summary>
    public sealed class ConnectStreamParams
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("parameters")]
        public List<Parameter> Parameters { get; set; } = new List<Parameter>();
    }

    /// <summary>Result of connect_stream: the id that stands for this stream until it ends.</summary>
    public sealed class ConnectStreamResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("stream_id")]
        public string StreamId { get; set; } = "";
    }

    /// <summary>Params of get_event_detail.</summary>
    public sealed class DetailParams
    {
        [JsonProperty("event_id", Required = Required.Always)]
        public string EventId { get; set; }

        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>Where the media of a section flow, as seen from the application.</summary>
    public enum Direction
    {
        [EnumMember(Value = "recvonly")]
        Recvonly,
        [EnumMember(Value = "sendonly")]
        Sendonly,
        [EnumMember(Value = "sendrecv")]
        Sendrecv,
    }

    /// <summary>
    /// Which engines came or are others now, and which have gone; in the place of
    /// <c>rois.system.profile_changed</c>.
    /// </summary>
    public sealed class DirectoryChangedNotification
    {
        [JsonProperty("changed")]
        public List<string> Changed { get; set; } = new List<string>();

        [JsonProperty("gone")]
        public List<string> Gone { get; set; } = new List<string>();

        [JsonProperty("unnamed")]
        public long Unnamed { get; set; } = 0;
    }

    /// <summary>
    /// Params of <c>openrois.directory.list</c>: the engines behind <c>after</c>, in the order of their
    /// ids.
    /// </summary>
    public sealed class DirectoryListParams
    {
        [JsonProperty("after")]
        public string After { get; set; } = "";

        [JsonProperty("limit")]
        public int Limit { get; set; } = 100;

        [JsonProperty("component_types")]
        public List<string> ComponentTypes { get; set; } = new List<string>();
    }

    /// <summary>
    /// Result of <c>openrois.directory.list</c>: <c>next</c> is the <c>after</c> of the next page, empty
    /// where there is none.
    /// </summary>
    public sealed class DirectoryListResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("engines")]
        public List<EngineEntry> Engines { get; set; } = new List<EngineEntry>();

        [JsonProperty("next")]
        public string Next { get; set; } = "";

        [JsonProperty("count")]
        public long Count { get; set; } = 0;
    }

    /// <summary>
    /// Params of <c>openrois.directory.profiles</c>: components whose profiles are wanted, one for each
    /// version suffices.
    /// </summary>
    public sealed class DirectoryProfilesParams
    {
        [JsonProperty("component_refs", Required = Required.Always)]
        public List<string> ComponentRefs { get; set; } = new List<string>();
    }

    /// <summary>
    /// Result of <c>openrois.directory.profiles</c>: profiles by <c>profile_version</c>; <c>left</c> are
    /// refs that found no room.
    /// </summary>
    public sealed class DirectoryProfilesResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("profiles")]
        public Dictionary<string, HRIComponentProfile> Profiles { get; set; } = new Dictionary<string, HRIComponentProfile>();

        [JsonProperty("left")]
        public List<string> Left { get; set; } = new List<string>();
    }

    /// <summary>Params of <c>openrois.directory.read</c>: the engines to be told of.</summary>
    public sealed class DirectoryReadParams
    {
        [JsonProperty("engine_ids", Required = Required.Always)]
        public List<string> EngineIds { get; set; } = new List<string>();
    }

    /// <summary>
    /// Result of <c>openrois.directory.read</c>: those that do not exist are absent; <c>left</c> are those
    /// that found no room.
    /// </summary>
    public sealed class DirectoryReadResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("engines")]
        public List<EngineEntry> Engines { get; set; } = new List<EngineEntry>();

        [JsonProperty("left")]
        public List<string> Left { get; set; } = new List<string>();
    }

    /// <summary>An engine in short.</summary>
    public sealed class EngineEntry
    {
        [JsonProperty("engine_id", Required = Required.Always)]
        public string EngineId { get; set; }

        [JsonProperty("parent_id", Required = Required.Always)]
        public string ParentId { get; set; }

        [JsonProperty("version", Required = Required.Always)]
        public string Version { get; set; }

        [JsonProperty("extensions")]
        public List<string> Extensions { get; set; } = new List<string>();

        [JsonProperty("components")]
        public List<ComponentEntry> Components { get; set; } = new List<ComponentEntry>();

        [JsonProperty("identifier", NullValueHandling = NullValueHandling.Ignore)]
        public RoISIdentifier Identifier { get; set; }

        [JsonProperty("parameter_profiles")]
        public List<ParameterProfile> ParameterProfiles { get; set; } = new List<ParameterProfile>();
    }

    /// <summary>Params of get_error_detail.</summary>
    public sealed class ErrorDetailParams
    {
        [JsonProperty("error_id", Required = Required.Always)]
        public string ErrorId { get; set; }

        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>Notification: an engine or a component reports a fault; get_error_detail tells more.</summary>
    public sealed class ErrorNotification
    {
        [JsonProperty("error_id", Required = Required.Always)]
        public string ErrorId { get; set; }

        [JsonProperty("error_type", Required = Required.Always)]
        public ErrorType ErrorType { get; set; }
    }

    /// <summary>What kind of error is notified (RoIS_Service::ErrorType).</summary>
    public enum ErrorType
    {
        [EnumMember(Value = "ENGINE_INTERNAL_ERROR")]
        EngineInternalError,
        [EnumMember(Value = "COMPONENT_INTERNAL_ERROR")]
        ComponentInternalError,
        [EnumMember(Value = "COMPONENT_NOT_RESPONDING")]
        ComponentNotResponding,
        [EnumMember(Value = "USER_DEFINED_ERROR")]
        UserDefinedError,
    }

    /// <summary>An event and its results; the schema gives events no arguments.</summary>
    public sealed class EventMessageProfile
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("results")]
        public List<ParameterProfile> Results { get; set; } = new List<ParameterProfile>();
    }

    /// <summary>
    /// Notification: an event happened. <c>results</c> is an extension that repeats what get_event_detail
    /// gives.
    /// </summary>
    public sealed class EventNotification
    {
        [JsonProperty("event_id", Required = Required.Always)]
        public string EventId { get; set; }

        [JsonProperty("event_type", Required = Required.Always)]
        public string EventType { get; set; }

        [JsonProperty("subscribe_id", Required = Required.Always)]
        public string SubscribeId { get; set; }

        [JsonProperty("expire")]
        public string Expire { get; set; } = "";

        [JsonProperty("results")]
        public List<Result> Results { get; set; } = new List<Result>();
    }

    /// <summary>
    /// Params of the notification <c>openrois.events_dropped</c>: how many events and errors should stand
    /// in its place.
    /// </summary>
    public sealed class EventsDroppedNotification
    {
        [JsonProperty("count", Required = Required.Always)]
        public long Count { get; set; }
    }

    /// <summary>Params of execute: a command unit sequence of at least one item.</summary>
    public sealed class ExecuteParams
    {
        [JsonProperty("command_unit_list", Required = Required.Always)]
        public List<ISequenceItem> CommandUnitList { get; set; } = new List<ISequenceItem>();
    }

    /// <summary>
    /// What one component understands. <c>name</c> is the instance's name; <c>function</c> and <c>part</c>
    /// are extensions of the wire.
    /// </summary>
    public sealed class HRIComponentProfile
    {
        [JsonProperty("identifier", Required = Required.Always)]
        public RoISIdentifier Identifier { get; set; }

        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("function", NullValueHandling = NullValueHandling.Ignore)]
        public ComponentFunction? Function { get; set; }

        [JsonProperty("part", NullValueHandling = NullValueHandling.Ignore)]
        public string Part { get; set; }

        [JsonProperty("sub_component_profiles")]
        public List<string> SubComponentProfiles { get; set; } = new List<string>();

        [JsonProperty("command_profiles")]
        public List<CommandMessageProfile> CommandProfiles { get; set; } = new List<CommandMessageProfile>();

        [JsonProperty("query_profiles")]
        public List<QueryMessageProfile> QueryProfiles { get; set; } = new List<QueryMessageProfile>();

        [JsonProperty("event_profiles")]
        public List<EventMessageProfile> EventProfiles { get; set; } = new List<EventMessageProfile>();

        [JsonProperty("parameter_profiles")]
        public List<ParameterProfile> ParameterProfiles { get; set; } = new List<ParameterProfile>();
    }

    /// <summary>
    /// An engine, the components that are reachable through it, and its sub-engines, each with those it has
    /// of them.
    /// </summary>
    public sealed class HRIEngineProfile
    {
        [JsonProperty("identifier", Required = Required.Always)]
        public RoISIdentifier Identifier { get; set; }

        [JsonProperty("sub_profiles")]
        public List<HRIEngineProfile> SubProfiles { get; set; } = new List<HRIEngineProfile>();

        [JsonProperty("component_ids")]
        public List<string> ComponentIds { get; set; } = new List<string>();

        [JsonProperty("parameter_profiles")]
        public List<ParameterProfile> ParameterProfiles { get; set; } = new List<ParameterProfile>();
    }

    /// <summary>Params of <c>openrois.hello</c>: the sender's extensions of the base wire.</summary>
    public sealed class HelloParams
    {
        [JsonProperty("version", Required = Required.Always)]
        public string Version { get; set; }

        [JsonProperty("extensions")]
        public List<string> Extensions { get; set; } = new List<string>();
    }

    /// <summary>Result of <c>openrois.hello</c>.</summary>
    public sealed class HelloResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("version")]
        public string Version { get; set; } = "1";

        [JsonProperty("extensions")]
        public List<string> Extensions { get; set; } = new List<string>();

        [JsonProperty("engines")]
        public List<string> Engines { get; set; } = new List<string>();

        [JsonProperty("client_id")]
        public string ClientId { get; set; } = "";

        [JsonProperty("instance")]
        public string Instance { get; set; } = "";

        [JsonProperty("epoch")]
        public long Epoch { get; set; } = 0;

        [JsonProperty("stopped")]
        public List<Stopped> Stopped { get; set; } = new List<Stopped>();
    }

    /// <summary>
    /// A STUN or TURN server in the form of the W3C dictionary RTCIceServer, with password credentials
    /// only.
    /// </summary>
    public sealed class IceServer
    {
        [JsonProperty("urls", Required = Required.Always)]
        public List<string> Urls { get; set; } = new List<string>();

        [JsonProperty("username", NullValueHandling = NullValueHandling.Ignore)]
        public string Username { get; set; }

        [JsonProperty("credential", NullValueHandling = NullValueHandling.Ignore)]
        public string Credential { get; set; }
    }

    /// <summary>
    /// Result of <c>signaling.ice_servers</c>: the servers to use, and for how many seconds their
    /// credentials hold.
    /// </summary>
    public sealed class IceServersResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("ice_servers")]
        public List<IceServer> IceServers { get; set; } = new List<IceServer>();

        [JsonProperty("ttl")]
        public long Ttl { get; set; } = 0;
    }

    /// <summary>What a session holds.</summary>
    public sealed class Lease
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("epoch", Required = Required.Always)]
        public long Epoch { get; set; }
    }

    /// <summary>Params of <c>openrois.lease.borrow</c>.</summary>
    public sealed class LeaseBorrowParams
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("duration_ms", NullValueHandling = NullValueHandling.Ignore)]
        public int? DurationMs { get; set; }

        [JsonProperty("ends_with")]
        public LoanEnd EndsWith { get; set; } = LoanEnd.Time;
    }

    /// <summary>
    /// Params of the notification <c>openrois.lease.changed</c>; <c>reason</c> is one sentence for a
    /// person.
    /// </summary>
    public sealed class LeaseChangedNotification
    {
        [JsonProperty("component_ref")]
        public string ComponentRef { get; set; } = "";

        [JsonProperty("state")]
        public LeaseState State { get; set; } = LeaseState.Free;

        [JsonProperty("holder")]
        public string Holder { get; set; } = "";

        [JsonProperty("epoch")]
        public long Epoch { get; set; } = 0;

        [JsonProperty("waiting")]
        public long Waiting { get; set; } = 0;

        [JsonProperty("position")]
        public long Position { get; set; } = 0;

        [JsonProperty("stopped_by")]
        public string StoppedBy { get; set; } = "";

        [JsonProperty("stop_id")]
        public string StopId { get; set; } = "";

        [JsonProperty("part")]
        public string Part { get; set; } = "";

        [JsonProperty("lender")]
        public string Lender { get; set; } = "";

        [JsonProperty("return_ms")]
        public long ReturnMs { get; set; } = 0;

        [JsonProperty("return_position")]
        public long ReturnPosition { get; set; } = 0;

        [JsonProperty("reason")]
        public string Reason { get; set; } = "";
    }

    /// <summary>
    /// Params of <c>openrois.lease.declined</c> to the client that asked, which waits on unless the
    /// component is gone.
    /// </summary>
    public sealed class LeaseDeclinedNotification
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("request_id", Required = Required.Always)]
        public string RequestId { get; set; }

        [JsonProperty("reason", Required = Required.Always)]
        public string Reason { get; set; }
    }

    /// <summary>
    /// Params of <c>openrois.lease.query</c>, <c>.request</c>, <c>.leave</c>, <c>.take</c> and
    /// <c>.give_back</c>.
    /// </summary>
    public sealed class LeaseParams
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }
    }

    /// <summary>
    /// Params of <c>openrois.lease.grant</c> and <c>.decline</c>: the <c>request_id</c> of a request that
    /// the holder received.
    /// </summary>
    public sealed class LeaseRequestParams
    {
        [JsonProperty("request_id", Required = Required.Always)]
        public string RequestId { get; set; }
    }

    /// <summary>
    /// Result of <c>openrois.lease.request</c>; <c>request_id</c> is empty where no holder has to be asked.
    /// </summary>
    public sealed class LeaseRequestResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("lease", NullValueHandling = NullValueHandling.Ignore)]
        public LeaseStatus Lease { get; set; }

        [JsonProperty("request_id")]
        public string RequestId { get; set; } = "";
    }

    /// <summary>
    /// Params of the notification <c>openrois.lease.requested</c> to the holder: <c>subject</c> asks, and
    /// waits so long.
    /// </summary>
    public sealed class LeaseRequestedNotification
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("request_id", Required = Required.Always)]
        public string RequestId { get; set; }

        [JsonProperty("subject", Required = Required.Always)]
        public string Subject { get; set; }

        [JsonProperty("answer_ms", Required = Required.Always)]
        public long AnswerMs { get; set; }
    }

    /// <summary>
    /// Result of <c>openrois.lease.query</c>, <c>.request</c>, <c>.borrow</c> and <c>.take</c>: the lease
    /// now.
    /// </summary>
    public sealed class LeaseResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("lease", NullValueHandling = NullValueHandling.Ignore)]
        public LeaseStatus Lease { get; set; }
    }

    /// <summary>The holder of a component, as the receiver sees it.</summary>
    public enum LeaseState
    {
        [EnumMember(Value = "FREE")]
        Free,
        [EnumMember(Value = "MINE")]
        Mine,
        [EnumMember(Value = "HELD")]
        Held,
        [EnumMember(Value = "ABSENT")]
        Absent,
    }

    /// <summary>The lease of one component, as the receiver sees it.</summary>
    public sealed class LeaseStatus
    {
        [JsonProperty("component_ref")]
        public string ComponentRef { get; set; } = "";

        [JsonProperty("state")]
        public LeaseState State { get; set; } = LeaseState.Free;

        [JsonProperty("holder")]
        public string Holder { get; set; } = "";

        [JsonProperty("epoch")]
        public long Epoch { get; set; } = 0;

        [JsonProperty("waiting")]
        public long Waiting { get; set; } = 0;

        [JsonProperty("position")]
        public long Position { get; set; } = 0;

        [JsonProperty("stopped_by")]
        public string StoppedBy { get; set; } = "";

        [JsonProperty("stop_id")]
        public string StopId { get; set; } = "";

        [JsonProperty("part")]
        public string Part { get; set; } = "";

        [JsonProperty("lender")]
        public string Lender { get; set; } = "";

        [JsonProperty("return_ms")]
        public long ReturnMs { get; set; } = 0;

        [JsonProperty("return_position")]
        public long ReturnPosition { get; set; } = 0;
    }

    /// <summary>
    /// Result of <c>openrois.lease.token</c>: good once, for this subject, so long after a lost connection.
    /// </summary>
    public sealed class LeaseTokenResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("token")]
        public string Token { get; set; } = "";

        [JsonProperty("grace_ms")]
        public long GraceMs { get; set; } = 0;
    }

    /// <summary>
    /// Params of the notification <c>openrois.lease.withdrawn</c> to the holder: its answer is not needed
    /// any more.
    /// </summary>
    public sealed class LeaseWithdrawnNotification
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("request_id", Required = Required.Always)]
        public string RequestId { get; set; }
    }

    /// <summary>What ends a loan, unless it is given back.</summary>
    public enum LoanEnd
    {
        [EnumMember(Value = "TIME")]
        Time,
        [EnumMember(Value = "COMMAND")]
        Command,
    }

    /// <summary>What a section of a peer connection carries.</summary>
    public enum MediaKind
    {
        [EnumMember(Value = "audio")]
        Audio,
        [EnumMember(Value = "video")]
        Video,
    }

    /// <summary>No params.</summary>
    public sealed class NoParams
    {
    }

    /// <summary>
    /// The engine's description number <c>generation</c> of the peer connection <c>peer_id</c>;
    /// <c>replaces</c> names the one it ends.
    /// </summary>
    public sealed class Offer
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }

        [JsonProperty("generation", Required = Required.Always)]
        public int Generation { get; set; }

        [JsonProperty("sdp", Required = Required.Always)]
        public string Sdp { get; set; }

        [JsonProperty("streams", Required = Required.Always)]
        public List<StreamSection> Streams { get; set; } = new List<StreamSection>();

        [JsonProperty("replaces", NullValueHandling = NullValueHandling.Ignore)]
        public string Replaces { get; set; }
    }

    /// <summary>A parameter of a component.</summary>
    public sealed class Parameter
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("data_type_ref", Required = Required.Always)]
        public string DataTypeRef { get; set; }

        [JsonProperty("value", Required = Required.Always)]
        public string Value { get; set; }
    }

    /// <summary>The name and type of a parameter, an argument or a result.</summary>
    public sealed class ParameterProfile
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("data_type_ref", Required = Required.Always)]
        public RoISIdentifier DataTypeRef { get; set; }

        [JsonProperty("default_value")]
        public string DefaultValue { get; set; } = "";

        [JsonProperty("description")]
        public string Description { get; set; } = "";
    }

    /// <summary>Result of get_parameter.</summary>
    public sealed class ParametersResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("parameters")]
        public List<Parameter> Parameters { get; set; } = new List<Parameter>();
    }

    /// <summary>Result of get_profile; <c>component_profiles</c> is an extension of the wire.</summary>
    public sealed class ProfileResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("profile", NullValueHandling = NullValueHandling.Ignore)]
        public HRIEngineProfile Profile { get; set; }

        [JsonProperty("component_profiles")]
        public Dictionary<string, HRIComponentProfile> ComponentProfiles { get; set; } = new Dictionary<string, HRIComponentProfile>();
    }

    /// <summary>What microphone and camera of a visitor may be used for. An extension of the wire.</summary>
    public enum Purpose
    {
        [EnumMember(Value = "live")]
        Live,
        [EnumMember(Value = "recognition")]
        Recognition,
        [EnumMember(Value = "agent")]
        Agent,
        [EnumMember(Value = "recording")]
        Recording,
        [EnumMember(Value = "transfer")]
        Transfer,
    }

    /// <summary>A query and its results; the schema gives queries no arguments.</summary>
    public sealed class QueryMessageProfile
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("results")]
        public List<ParameterProfile> Results { get; set; } = new List<ParameterProfile>();
    }

    /// <summary>Params of query.</summary>
    public sealed class QueryParams
    {
        [JsonProperty("query_type", Required = Required.Always)]
        public string QueryType { get; set; }

        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>
    /// Params of the notification <c>openrois.reason</c>: why the message right behind it says something
    /// else than OK.
    /// </summary>
    public sealed class ReasonNotification
    {
        [JsonProperty("request_id", NullValueHandling = NullValueHandling.Ignore)]
        [JsonConverter(typeof(IdentityConverter))]
        public object RequestId { get; set; }

        [JsonProperty("command_id", NullValueHandling = NullValueHandling.Ignore)]
        public string CommandId { get; set; }

        [JsonProperty("reason", Required = Required.Always)]
        public string Reason { get; set; }
    }

    /// <summary>Result of bind_any.</summary>
    public sealed class ReferenceResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("component_ref")]
        public string ComponentRef { get; set; } = "";
    }

    /// <summary>Params of <c>openrois.lease.release_stop</c>: an engine, or the one of a component.</summary>
    public sealed class ReleaseStopParams
    {
        [JsonProperty("engine_id", NullValueHandling = NullValueHandling.Ignore)]
        public string EngineId { get; set; }

        [JsonProperty("component_ref", NullValueHandling = NullValueHandling.Ignore)]
        public string ComponentRef { get; set; }

        [JsonProperty("stop_id", NullValueHandling = NullValueHandling.Ignore)]
        public string StopId { get; set; }
    }

    /// <summary>
    /// Params of report_playout: milliseconds from the arrival of the stream's media to their being played
    /// or shown.
    /// </summary>
    public sealed class ReportPlayoutParams
    {
        [JsonProperty("stream_id", Required = Required.Always)]
        public string StreamId { get; set; }

        [JsonProperty("milliseconds", Required = Required.Always)]
        public int Milliseconds { get; set; }
    }

    /// <summary>The application's request for a new peer connection in place of <c>peer_id</c>.</summary>
    public sealed class Restart
    {
        [JsonProperty("peer_id", Required = Required.Always)]
        public string PeerId { get; set; }
    }

    /// <summary>
    /// A named value with its type; <c>value</c> is always text, see <c>openrois.types.values</c>.
    /// </summary>
    public sealed class Result
    {
        [JsonProperty("name", Required = Required.Always)]
        public string Name { get; set; }

        [JsonProperty("data_type_ref", Required = Required.Always)]
        public string DataTypeRef { get; set; }

        [JsonProperty("value", Required = Required.Always)]
        public string Value { get; set; }
    }

    /// <summary>Result of query, get_command_result, get_event_detail and get_error_detail.</summary>
    public sealed class ResultsResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("results")]
        public List<Result> Results { get; set; } = new List<Result>();
    }

    /// <summary>
    /// Params of <c>openrois.lease.resume</c>; <c>command_ids</c> are the commands whose end is not known.
    /// </summary>
    public sealed class ResumeParams
    {
        [JsonProperty("token", Required = Required.Always)]
        public string Token { get; set; }

        [JsonProperty("command_ids")]
        public List<string> CommandIds { get; set; } = new List<string>();
    }

    /// <summary>
    /// Result of <c>openrois.lease.resume</c>: the next token, what is held, and which commands are not
    /// known.
    /// </summary>
    public sealed class ResumeResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("token")]
        public string Token { get; set; } = "";

        [JsonProperty("grace_ms")]
        public long GraceMs { get; set; } = 0;

        [JsonProperty("leases")]
        public List<Lease> Leases { get; set; } = new List<Lease>();

        [JsonProperty("forgotten")]
        public List<string> Forgotten { get; set; } = new List<string>();
    }

    /// <summary>How an operation ended (RoIS_HRI::ReturnCode_t).</summary>
    public enum ReturnCode
    {
        [EnumMember(Value = "OK")]
        Ok,
        [EnumMember(Value = "ERROR")]
        Error,
        [EnumMember(Value = "BAD_PARAMETER")]
        BadParameter,
        [EnumMember(Value = "UNSUPPORTED")]
        Unsupported,
        [EnumMember(Value = "OUT_OF_RESOURCES")]
        OutOfResources,
        [EnumMember(Value = "TIMEOUT")]
        Timeout,
    }

    /// <summary>A result without out parameters. On the wire its return code always stands.</summary>
    public sealed class ReturnResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }
    }

    /// <summary>
    /// An identifier (RoISIdentifierType): a code, and the authority and book that give it its meaning.
    /// </summary>
    public sealed class RoISIdentifier
    {
        [JsonProperty("code", Required = Required.Always)]
        public string Code { get; set; }

        [JsonProperty("authority")]
        public string Authority { get; set; } = "";

        [JsonProperty("codebook_ref")]
        public string CodebookRef { get; set; } = "";

        [JsonProperty("version")]
        public string Version { get; set; } = "";
    }

    /// <summary>Result of search.</summary>
    public sealed class SearchResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("component_ref_list")]
        public List<string> ComponentRefList { get; set; } = new List<string>();
    }

    /// <summary>
    /// What one sender's RTP timestamps mean: a frame with the timestamp <c>rtp_origin</c> was captured at
    /// <c>wall</c>.
    /// </summary>
    public sealed class SenderClock
    {
        [JsonProperty("mid", Required = Required.Always)]
        public string Mid { get; set; }

        [JsonProperty("ssrc", Required = Required.Always)]
        public long Ssrc { get; set; }

        [JsonProperty("clock_rate", Required = Required.Always)]
        public int ClockRate { get; set; }

        [JsonProperty("rtp_origin", Required = Required.Always)]
        public long RtpOrigin { get; set; }

        [JsonProperty("wall", Required = Required.Always)]
        public long Wall { get; set; }
    }

    /// <summary>One item of a command sequence; items run one after another.</summary>
    public interface ISequenceItem
    {
    }

    /// <summary>Reads each SequenceItem as the type that it is.</summary>
    public sealed class SequenceItemConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type == typeof(ISequenceItem);
        }

        public override object ReadJson(
            JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            JObject read = JObject.Load(reader);
            if (read["command_list"] != null)
            {
                return read.ToObject<ConcurrentCommands>(serializer);
            }
            return read.ToObject<CommandUnit>(serializer);
        }
    }

    /// <summary>
    /// Params of set_consent: all that the sender of the stream consents to from now on; the rest is
    /// withdrawn.
    /// </summary>
    public sealed class SetConsentParams
    {
        [JsonProperty("stream_id", Required = Required.Always)]
        public string StreamId { get; set; }

        [JsonProperty("consent", Required = Required.Always)]
        public List<Purpose> Consent { get; set; } = new List<Purpose>();
    }

    /// <summary>Result of set_consent: the name of the visitor that the application is to others.</summary>
    public sealed class SetConsentResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("visitor_ref")]
        public string VisitorRef { get; set; } = "";
    }

    /// <summary>Params of set_parameter: several parameters are one change.</summary>
    public sealed class SetParameterParams
    {
        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("parameters", Required = Required.Always)]
        public List<Parameter> Parameters { get; set; } = new List<Parameter>();
    }

    /// <summary>Result of set_parameter; the outcome comes as <c>completed</c> with this id.</summary>
    public sealed class SetParameterResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("command_id")]
        public string CommandId { get; set; } = "";
    }

    /// <summary>
    /// Params of <c>openrois.stop_all</c>: an engine, or the one of a component; without both all that one
    /// controls.
    /// </summary>
    public sealed class StopAllParams
    {
        [JsonProperty("engine_id", NullValueHandling = NullValueHandling.Ignore)]
        public string EngineId { get; set; }

        [JsonProperty("component_ref", NullValueHandling = NullValueHandling.Ignore)]
        public string ComponentRef { get; set; }

        [JsonProperty("stop_id", NullValueHandling = NullValueHandling.Ignore)]
        public string StopId { get; set; }
    }

    /// <summary>
    /// Result of <c>openrois.stop_all</c>: which components have stopped, and which have not confirmed it
    /// in time.
    /// </summary>
    public sealed class StopAllResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("stopped")]
        public List<string> Stopped { get; set; } = new List<string>();

        [JsonProperty("failed")]
        public List<string> Failed { get; set; } = new List<string>();
    }

    /// <summary>An engine, the person that has stopped it for programs, and the id of that STOP.</summary>
    public sealed class Stopped
    {
        [JsonProperty("engine_id", Required = Required.Always)]
        public string EngineId { get; set; }

        [JsonProperty("by", Required = Required.Always)]
        public string By { get; set; }

        [JsonProperty("stop_id")]
        public string StopId { get; set; } = "";
    }

    /// <summary>
    /// Params of the notification <c>openrois.lease.stopped</c>, to applications and to the adapter of the
    /// engine.
    /// </summary>
    public sealed class StoppedNotification
    {
        [JsonProperty("engine_id", Required = Required.Always)]
        public string EngineId { get; set; }

        [JsonProperty("by")]
        public string By { get; set; } = "";

        [JsonProperty("reason")]
        public string Reason { get; set; } = "";

        [JsonProperty("stop_id")]
        public string StopId { get; set; } = "";
    }

    /// <summary>Params of every method that acts on a connected stream.</summary>
    public sealed class StreamParams
    {
        [JsonProperty("stream_id", Required = Required.Always)]
        public string StreamId { get; set; }
    }

    /// <summary>Which m-section of an offer carries which stream.</summary>
    public sealed class StreamSection
    {
        [JsonProperty("mid", Required = Required.Always)]
        public string Mid { get; set; }

        [JsonProperty("stream_id", Required = Required.Always)]
        public string StreamId { get; set; }

        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("kind", Required = Required.Always)]
        public MediaKind Kind { get; set; }

        [JsonProperty("direction", Required = Required.Always)]
        public Direction Direction { get; set; }
    }

    /// <summary>
    /// The state of a stream (Stream_Status, table 8.10); RESUMED is announced as an event and is never a
    /// state.
    /// </summary>
    public enum StreamStatus
    {
        [EnumMember(Value = "STREAMING_NOT_CONNECTED")]
        StreamingNotConnected,
        [EnumMember(Value = "STREAMING_NOT_RUNNING")]
        StreamingNotRunning,
        [EnumMember(Value = "STREAMING_RUNNING")]
        StreamingRunning,
        [EnumMember(Value = "STREAMING_SUSPENDED")]
        StreamingSuspended,
        [EnumMember(Value = "STREAMING_RESUMED")]
        StreamingResumed,
    }

    /// <summary>
    /// Params of the notification <c>rois.stream.notify_stream_status</c>; <c>timestamp</c> is a DateTime.
    /// </summary>
    public sealed class StreamStatusNotification
    {
        [JsonProperty("stream_id", Required = Required.Always)]
        public string StreamId { get; set; }

        [JsonProperty("component_ref", Required = Required.Always)]
        public string ComponentRef { get; set; }

        [JsonProperty("status", Required = Required.Always)]
        public StreamStatus Status { get; set; }

        [JsonProperty("timestamp", Required = Required.Always)]
        public string Timestamp { get; set; }
    }

    /// <summary>Result of query_stream_status.</summary>
    public sealed class StreamStatusResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("status")]
        public StreamStatus Status { get; set; } = StreamStatus.StreamingNotConnected;
    }

    /// <summary>Params of subscribe.</summary>
    public sealed class SubscribeParams
    {
        [JsonProperty("event_type", Required = Required.Always)]
        public string EventType { get; set; }

        [JsonProperty("condition")]
        public string Condition { get; set; } = "";
    }

    /// <summary>Result of subscribe.</summary>
    public sealed class SubscribeResult : IOutcome
    {
        [JsonProperty("return_code", Required = Required.Always)]
        public ReturnCode ReturnCode { get; set; }

        [JsonProperty("subscribe_id")]
        public string SubscribeId { get; set; } = "";
    }

    /// <summary>Params of unsubscribe.</summary>
    public sealed class UnsubscribeParams
    {
        [JsonProperty("subscribe_id", Required = Required.Always)]
        public string SubscribeId { get; set; }
    }

    /// <summary>The converters of all unions.</summary>
    internal static class Unions
    {
        internal static readonly JsonConverter[] Converters = { new SequenceItemConverter() };
    }
}
