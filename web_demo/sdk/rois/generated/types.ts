/** Types of the wire, named as in the data model. Written by `make generate`; edits are lost. */

/** The application's description for the offer of the same generation. */
export interface Answer {
  readonly peer_id: string;
  readonly generation: number;
  readonly sdp: string;
}

/** An argument of a command. */
export interface Argument {
  readonly name: string;
  readonly data_type_ref: string;
  readonly value: string;
}

/** Params of the notification `openrois.auth.expiring`: in how many seconds the connection will be closed. */
export interface AuthExpiringNotification {
  readonly seconds: number;
}

/**
 * Params of `openrois.auth.refresh`: a token of the same subject, from now on in place of the present
 * one.
 */
export interface AuthRefreshParams {
  readonly token: string;
}

/** Result of `openrois.auth.refresh`: for how many seconds the connection may now go on. */
export interface AuthRefreshResult {
  readonly return_code: ReturnCode;
  readonly seconds?: number;
}

/** The deliberate end of a peer connection; `reason` is a sentence for a person. */
export interface Bye {
  readonly peer_id: string;
  readonly reason: string;
}

/** One ICE candidate of the sender, belonging to the description of `generation`. */
export interface Candidate {
  readonly peer_id: string;
  readonly generation: number;
  readonly candidate: string | null;
  readonly sdp_mid?: string | null;
  readonly sdp_m_line_index?: number | null;
}

/** The clocks of the senders of a peer connection, each by the m-section and the SSRC that it sends with. */
export interface CaptureClocks {
  readonly peer_id: string;
  readonly senders: readonly SenderClock[];
}

/** A command: what it takes, what `get_command_result` gives, and the milliseconds it may take. */
export interface CommandMessageProfile {
  readonly name: string;
  readonly results?: readonly ParameterProfile[];
  readonly arguments?: readonly ParameterProfile[];
  readonly timeout?: number | null;
}

/** Params of get_command_result. */
export interface CommandResultParams {
  readonly command_id: string;
  readonly condition?: string;
}

/** One command. `delay_time` is the milliseconds between its turn and its start. */
export interface CommandUnit {
  readonly component_ref: string;
  readonly command_type: string;
  readonly command_id: string;
  readonly arguments?: readonly Argument[];
  readonly delay_time?: number | null;
}

/** Notification: a command has ended, sent exactly once. */
export interface Completed {
  readonly command_id: string;
  readonly status: CompletedStatus;
}

/** How a command ended (RoIS_Service::Completed_Status). */
export const CompletedStatus = ["OK", "ERROR", "ABORT", "OUT_OF_RESOURCES", "TIMEOUT"] as const;
export type CompletedStatus = (typeof CompletedStatus)[number];

/** A component in short. */
export interface ComponentEntry {
  readonly component_ref: string;
  readonly component_type: string;
  readonly function?: ComponentFunction | null;
  readonly profile_version: string;
}

/**
 * The class of a component: only an actuation has to be bound before it is operated. An extension of
 * the wire.
 */
export const ComponentFunction = ["actuation", "sensing", "function"] as const;
export type ComponentFunction = (typeof ComponentFunction)[number];

/** Params of bind, release and get_parameter. */
export interface ComponentParams {
  readonly component_ref: string;
}

/** What a component is able to do now (RoIS_Common::Component_Status). */
export const ComponentStatus = ["UNINITIALIZED", "READY", "BUSY", "WARNING", "ERROR"] as const;
export type ComponentStatus = (typeof ComponentStatus)[number];

/** Commands that run at the same time; the next item of the sequence waits for all of them. */
export interface ConcurrentCommands {
  readonly command_list: readonly CommandUnit[];
  readonly delay_time?: number | null;
}

/** Params of get_profile, search and bind_any: a condition, empty for everything. */
export interface ConditionParams {
  readonly condition?: string;
}

/**
 * Params of connect_stream; parameters are `encoding_parameters` and `transport_parameters`, JSON text
 * each.
 */
export interface ConnectStreamParams {
  readonly component_ref: string;
  readonly parameters?: readonly Parameter[];
}

/** Result of connect_stream: the id that stands for this stream until it ends. */
export interface ConnectStreamResult {
  readonly return_code: ReturnCode;
  readonly stream_id?: string;
}

/** Params of get_event_detail. */
export interface DetailParams {
  readonly event_id: string;
  readonly condition?: string;
}

/** Where the media of a section flow, as seen from the application. */
export const Direction = ["recvonly", "sendonly", "sendrecv"] as const;
export type Direction = (typeof Direction)[number];

/**
 * Which engines came or are others now, and which have gone; in the place of
 * `rois.system.profile_changed`.
 */
export interface DirectoryChangedNotification {
  readonly changed?: readonly string[];
  readonly gone?: readonly string[];
  readonly unnamed?: number;
}

/** Params of `openrois.directory.list`: the engines behind `after`, in the order of their ids. */
export interface DirectoryListParams {
  readonly after?: string;
  readonly limit?: number;
  readonly component_types?: readonly string[];
}

/** Result of `openrois.directory.list`: `next` is the `after` of the next page, empty where there is none. */
export interface DirectoryListResult {
  readonly return_code: ReturnCode;
  readonly engines?: readonly EngineEntry[];
  readonly next?: string;
  readonly count?: number;
}

/**
 * Params of `openrois.directory.profiles`: components whose profiles are wanted, one for each version
 * suffices.
 */
export interface DirectoryProfilesParams {
  readonly component_refs: readonly string[];
}

/**
 * Result of `openrois.directory.profiles`: profiles by `profile_version`; `left` are refs that found
 * no room.
 */
export interface DirectoryProfilesResult {
  readonly return_code: ReturnCode;
  readonly profiles?: { readonly [name: string]: HRIComponentProfile };
  readonly left?: readonly string[];
}

/** Params of `openrois.directory.read`: the engines to be told of. */
export interface DirectoryReadParams {
  readonly engine_ids: readonly string[];
}

/**
 * Result of `openrois.directory.read`: those that do not exist are absent; `left` are those that found
 * no room.
 */
export interface DirectoryReadResult {
  readonly return_code: ReturnCode;
  readonly engines?: readonly EngineEntry[];
  readonly left?: readonly string[];
}

/** An engine in short. */
export interface EngineEntry {
  readonly engine_id: string;
  readonly parent_id: string;
  readonly version: string;
  readonly extensions?: readonly string[];
  readonly components?: readonly ComponentEntry[];
  readonly identifier?: RoISIdentifier | null;
  readonly parameter_profiles?: readonly ParameterProfile[];
}

/** Params of get_error_detail. */
export interface ErrorDetailParams {
  readonly error_id: string;
  readonly condition?: string;
}

/** Notification: an engine or a component reports a fault; get_error_detail tells more. */
export interface ErrorNotification {
  readonly error_id: string;
  readonly error_type: ErrorType;
}

/** What kind of error is notified (RoIS_Service::ErrorType). */
export const ErrorType = [
  "ENGINE_INTERNAL_ERROR",
  "COMPONENT_INTERNAL_ERROR",
  "COMPONENT_NOT_RESPONDING",
  "USER_DEFINED_ERROR",
] as const;
export type ErrorType = (typeof ErrorType)[number];

/** An event and its results; the schema gives events no arguments. */
export interface EventMessageProfile {
  readonly name: string;
  readonly results?: readonly ParameterProfile[];
}

/** Notification: an event happened. `results` is an extension that repeats what get_event_detail gives. */
export interface EventNotification {
  readonly event_id: string;
  readonly event_type: string;
  readonly subscribe_id: string;
  readonly expire?: string;
  readonly results?: readonly Result[];
}

/**
 * Params of the notification `openrois.events_dropped`: how many events and errors should stand in its
 * place.
 */
export interface EventsDroppedNotification {
  readonly count: number;
}

/** Params of execute: a command unit sequence of at least one item. */
export interface ExecuteParams {
  readonly command_unit_list: readonly SequenceItem[];
}

/**
 * What one component understands. `name` is the instance's name; `function` and `part` are extensions
 * of the wire.
 */
export interface HRIComponentProfile {
  readonly identifier: RoISIdentifier;
  readonly name: string;
  readonly function?: ComponentFunction | null;
  readonly part?: string | null;
  readonly sub_component_profiles?: readonly string[];
  readonly command_profiles?: readonly CommandMessageProfile[];
  readonly query_profiles?: readonly QueryMessageProfile[];
  readonly event_profiles?: readonly EventMessageProfile[];
  readonly parameter_profiles?: readonly ParameterProfile[];
}

/**
 * An engine, the components that are reachable through it, and its sub-engines, each with those it has
 * of them.
 */
export interface HRIEngineProfile {
  readonly identifier: RoISIdentifier;
  readonly sub_profiles?: readonly HRIEngineProfile[];
  readonly component_ids?: readonly string[];
  readonly parameter_profiles?: readonly ParameterProfile[];
}

/** Params of `openrois.hello`: the sender's extensions of the base wire. */
export interface HelloParams {
  readonly version: string;
  readonly extensions?: readonly string[];
}

/** Result of `openrois.hello`. */
export interface HelloResult {
  readonly return_code: ReturnCode;
  readonly version?: string;
  readonly extensions?: readonly string[];
  readonly engines?: readonly string[];
  readonly client_id?: string;
  readonly instance?: string;
  readonly epoch?: number;
  readonly stopped?: readonly Stopped[];
}

/** A STUN or TURN server in the form of the W3C dictionary RTCIceServer, with password credentials only. */
export interface IceServer {
  readonly urls: readonly string[];
  readonly username?: string | null;
  readonly credential?: string | null;
}

/** Result of `signaling.ice_servers`: the servers to use, and for how many seconds their credentials hold. */
export interface IceServersResult {
  readonly return_code: ReturnCode;
  readonly ice_servers?: readonly IceServer[];
  readonly ttl?: number;
}

/** What a session holds. */
export interface Lease {
  readonly component_ref: string;
  readonly epoch: number;
}

/** Params of `openrois.lease.borrow`. */
export interface LeaseBorrowParams {
  readonly component_ref: string;
  readonly duration_ms?: number | null;
  readonly ends_with?: LoanEnd;
}

/** Params of the notification `openrois.lease.changed`; `reason` is one sentence for a person. */
export interface LeaseChangedNotification {
  readonly component_ref?: string;
  readonly state?: LeaseState;
  readonly holder?: string;
  readonly epoch?: number;
  readonly waiting?: number;
  readonly position?: number;
  readonly stopped_by?: string;
  readonly stop_id?: string;
  readonly part?: string;
  readonly lender?: string;
  readonly return_ms?: number;
  readonly return_position?: number;
  readonly reason?: string;
}

/**
 * Params of `openrois.lease.declined` to the client that asked, which waits on unless the component is
 * gone.
 */
export interface LeaseDeclinedNotification {
  readonly component_ref: string;
  readonly request_id: string;
  readonly reason: string;
}

/** Params of `openrois.lease.query`, `.request`, `.leave`, `.take` and `.give_back`. */
export interface LeaseParams {
  readonly component_ref: string;
}

/**
 * Params of `openrois.lease.grant` and `.decline`: the `request_id` of a request that the holder
 * received.
 */
export interface LeaseRequestParams {
  readonly request_id: string;
}

/** Result of `openrois.lease.request`; `request_id` is empty where no holder has to be asked. */
export interface LeaseRequestResult {
  readonly return_code: ReturnCode;
  readonly lease?: LeaseStatus | null;
  readonly request_id?: string;
}

/** Params of the notification `openrois.lease.requested` to the holder: `subject` asks, and waits so long. */
export interface LeaseRequestedNotification {
  readonly component_ref: string;
  readonly request_id: string;
  readonly subject: string;
  readonly answer_ms: number;
}

/** Result of `openrois.lease.query`, `.request`, `.borrow` and `.take`: the lease now. */
export interface LeaseResult {
  readonly return_code: ReturnCode;
  readonly lease?: LeaseStatus | null;
}

/** The holder of a component, as the receiver sees it. */
export const LeaseState = ["FREE", "MINE", "HELD", "ABSENT"] as const;
export type LeaseState = (typeof LeaseState)[number];

/** The lease of one component, as the receiver sees it. */
export interface LeaseStatus {
  readonly component_ref?: string;
  readonly state?: LeaseState;
  readonly holder?: string;
  readonly epoch?: number;
  readonly waiting?: number;
  readonly position?: number;
  readonly stopped_by?: string;
  readonly stop_id?: string;
  readonly part?: string;
  readonly lender?: string;
  readonly return_ms?: number;
  readonly return_position?: number;
}

/** Result of `openrois.lease.token`: good once, for this subject, so long after a lost connection. */
export interface LeaseTokenResult {
  readonly return_code: ReturnCode;
  readonly token?: string;
  readonly grace_ms?: number;
}

/** Params of the notification `openrois.lease.withdrawn` to the holder: its answer is not needed any more. */
export interface LeaseWithdrawnNotification {
  readonly component_ref: string;
  readonly request_id: string;
}

/** What ends a loan, unless it is given back. */
export const LoanEnd = ["TIME", "COMMAND"] as const;
export type LoanEnd = (typeof LoanEnd)[number];

/** What a section of a peer connection carries. */
export const MediaKind = ["audio", "video"] as const;
export type MediaKind = (typeof MediaKind)[number];

/** No params. */
export type NoParams = { readonly [name: string]: never };

/**
 * The engine's description number `generation` of the peer connection `peer_id`; `replaces` names the
 * one it ends.
 */
export interface Offer {
  readonly peer_id: string;
  readonly generation: number;
  readonly sdp: string;
  readonly streams: readonly StreamSection[];
  readonly replaces?: string | null;
}

/** A parameter of a component. */
export interface Parameter {
  readonly name: string;
  readonly data_type_ref: string;
  readonly value: string;
}

/** The name and type of a parameter, an argument or a result. */
export interface ParameterProfile {
  readonly name: string;
  readonly data_type_ref: RoISIdentifier;
  readonly default_value?: string;
  readonly description?: string;
}

/** Result of get_parameter. */
export interface ParametersResult {
  readonly return_code: ReturnCode;
  readonly parameters?: readonly Parameter[];
}

/** Result of get_profile; `component_profiles` is an extension of the wire. */
export interface ProfileResult {
  readonly return_code: ReturnCode;
  readonly profile?: HRIEngineProfile | null;
  readonly component_profiles?: { readonly [name: string]: HRIComponentProfile };
}

/** What microphone and camera of a visitor may be used for. An extension of the wire. */
export const Purpose = ["live", "recognition", "agent", "recording", "transfer"] as const;
export type Purpose = (typeof Purpose)[number];

/** A query and its results; the schema gives queries no arguments. */
export interface QueryMessageProfile {
  readonly name: string;
  readonly results?: readonly ParameterProfile[];
}

/** Params of query. */
export interface QueryParams {
  readonly query_type: string;
  readonly condition?: string;
}

/**
 * Params of the notification `openrois.reason`: why the message right behind it says something else
 * than OK.
 */
export interface ReasonNotification {
  readonly request_id?: string | number | null;
  readonly command_id?: string | null;
  readonly reason: string;
}

/** Result of bind_any. */
export interface ReferenceResult {
  readonly return_code: ReturnCode;
  readonly component_ref?: string;
}

/** Params of `openrois.lease.release_stop`: an engine, or the one of a component. */
export interface ReleaseStopParams {
  readonly engine_id?: string | null;
  readonly component_ref?: string | null;
  readonly stop_id?: string | null;
}

/**
 * Params of report_playout: milliseconds from the arrival of the stream's media to their being played
 * or shown.
 */
export interface ReportPlayoutParams {
  readonly stream_id: string;
  readonly milliseconds: number;
}

/** The application's request for a new peer connection in place of `peer_id`. */
export interface Restart {
  readonly peer_id: string;
}

/** A named value with its type; `value` is always text, see `openrois.types.values`. */
export interface Result {
  readonly name: string;
  readonly data_type_ref: string;
  readonly value: string;
}

/** Result of query, get_command_result, get_event_detail and get_error_detail. */
export interface ResultsResult {
  readonly return_code: ReturnCode;
  readonly results?: readonly Result[];
}

/** Params of `openrois.lease.resume`; `command_ids` are the commands whose end is not known. */
export interface ResumeParams {
  readonly token: string;
  readonly command_ids?: readonly string[];
}

/** Result of `openrois.lease.resume`: the next token, what is held, and which commands are not known. */
export interface ResumeResult {
  readonly return_code: ReturnCode;
  readonly token?: string;
  readonly grace_ms?: number;
  readonly leases?: readonly Lease[];
  readonly forgotten?: readonly string[];
}

/** How an operation ended (RoIS_HRI::ReturnCode_t). */
export const ReturnCode = [
  "OK",
  "ERROR",
  "BAD_PARAMETER",
  "UNSUPPORTED",
  "OUT_OF_RESOURCES",
  "TIMEOUT",
] as const;
export type ReturnCode = (typeof ReturnCode)[number];

/** A result without out parameters. On the wire its return code always stands. */
export interface ReturnResult {
  readonly return_code: ReturnCode;
}

/** An identifier (RoISIdentifierType): a code, and the authority and book that give it its meaning. */
export interface RoISIdentifier {
  readonly code: string;
  readonly authority?: string;
  readonly codebook_ref?: string;
  readonly version?: string;
}

/** Result of search. */
export interface SearchResult {
  readonly return_code: ReturnCode;
  readonly component_ref_list?: readonly string[];
}

/** What one sender's RTP timestamps mean: a frame with the timestamp `rtp_origin` was captured at `wall`. */
export interface SenderClock {
  readonly mid: string;
  readonly ssrc: number;
  readonly clock_rate: number;
  readonly rtp_origin: number;
  readonly wall: number;
}

/** One item of a command sequence; items run one after another. */
export type SequenceItem = CommandUnit | ConcurrentCommands;

/**
 * Params of set_consent: all that the sender of the stream consents to from now on; the rest is
 * withdrawn.
 */
export interface SetConsentParams {
  readonly stream_id: string;
  readonly consent: readonly Purpose[];
}

/** Result of set_consent: the name of the visitor that the application is to others. */
export interface SetConsentResult {
  readonly return_code: ReturnCode;
  readonly visitor_ref?: string;
}

/** Params of set_parameter: several parameters are one change. */
export interface SetParameterParams {
  readonly component_ref: string;
  readonly parameters: readonly Parameter[];
}

/** Result of set_parameter; the outcome comes as `completed` with this id. */
export interface SetParameterResult {
  readonly return_code: ReturnCode;
  readonly command_id?: string;
}

/**
 * Params of `openrois.stop_all`: an engine, or the one of a component; without both all that one
 * controls.
 */
export interface StopAllParams {
  readonly engine_id?: string | null;
  readonly component_ref?: string | null;
  readonly stop_id?: string | null;
}

/** Result of `openrois.stop_all`: which components have stopped, and which have not confirmed it in time. */
export interface StopAllResult {
  readonly return_code: ReturnCode;
  readonly stopped?: readonly string[];
  readonly failed?: readonly string[];
}

/** An engine, the person that has stopped it for programs, and the id of that STOP. */
export interface Stopped {
  readonly engine_id: string;
  readonly by: string;
  readonly stop_id?: string;
}

/** Params of the notification `openrois.lease.stopped`, to applications and to the adapter of the engine. */
export interface StoppedNotification {
  readonly engine_id: string;
  readonly by?: string;
  readonly reason?: string;
  readonly stop_id?: string;
}

/** Params of every method that acts on a connected stream. */
export interface StreamParams {
  readonly stream_id: string;
}

/** Which m-section of an offer carries which stream. */
export interface StreamSection {
  readonly mid: string;
  readonly stream_id: string;
  readonly component_ref: string;
  readonly kind: MediaKind;
  readonly direction: Direction;
}

/**
 * The state of a stream (Stream_Status, table 8.10); RESUMED is announced as an event and is never a
 * state.
 */
export const StreamStatus = [
  "STREAMING_NOT_CONNECTED",
  "STREAMING_NOT_RUNNING",
  "STREAMING_RUNNING",
  "STREAMING_SUSPENDED",
  "STREAMING_RESUMED",
] as const;
export type StreamStatus = (typeof StreamStatus)[number];

/** Params of the notification `rois.stream.notify_stream_status`; `timestamp` is a DateTime. */
export interface StreamStatusNotification {
  readonly stream_id: string;
  readonly component_ref: string;
  readonly status: StreamStatus;
  readonly timestamp: string;
}

/** Result of query_stream_status. */
export interface StreamStatusResult {
  readonly return_code: ReturnCode;
  readonly status?: StreamStatus;
}

/** Params of subscribe. */
export interface SubscribeParams {
  readonly event_type: string;
  readonly condition?: string;
}

/** Result of subscribe. */
export interface SubscribeResult {
  readonly return_code: ReturnCode;
  readonly subscribe_id?: string;
}

/** Params of unsubscribe. */
export interface UnsubscribeParams {
  readonly subscribe_id: string;
}
