/** What each method and notification of the wire carries. Written by `make generate`; edits are lost. */

import type {
  Answer,
  AuthExpiringNotification,
  AuthRefreshParams,
  AuthRefreshResult,
  Bye,
  Candidate,
  CaptureClocks,
  CommandResultParams,
  Completed,
  ComponentParams,
  ConditionParams,
  ConnectStreamParams,
  ConnectStreamResult,
  DetailParams,
  DirectoryChangedNotification,
  DirectoryListParams,
  DirectoryListResult,
  DirectoryProfilesParams,
  DirectoryProfilesResult,
  DirectoryReadParams,
  DirectoryReadResult,
  ErrorDetailParams,
  ErrorNotification,
  EventNotification,
  EventsDroppedNotification,
  ExecuteParams,
  HelloParams,
  HelloResult,
  IceServersResult,
  LeaseBorrowParams,
  LeaseChangedNotification,
  LeaseDeclinedNotification,
  LeaseParams,
  LeaseRequestParams,
  LeaseRequestResult,
  LeaseRequestedNotification,
  LeaseResult,
  LeaseTokenResult,
  LeaseWithdrawnNotification,
  NoParams,
  Offer,
  ParametersResult,
  ProfileResult,
  QueryParams,
  ReasonNotification,
  ReferenceResult,
  ReleaseStopParams,
  ReportPlayoutParams,
  Restart,
  ResultsResult,
  ResumeParams,
  ResumeResult,
  ReturnResult,
  SearchResult,
  SetConsentParams,
  SetConsentResult,
  SetParameterParams,
  SetParameterResult,
  StopAllParams,
  StopAllResult,
  StoppedNotification,
  StreamParams,
  StreamStatusNotification,
  StreamStatusResult,
  SubscribeParams,
  SubscribeResult,
  UnsubscribeParams,
} from "./types.ts";

/** Params and result of every method that an application may call. */
export interface Methods {
  /** Begin a session. */
  readonly "rois.system.connect": { params: NoParams; result: ReturnResult };
  /** End it: what it has bound and subscribed is free. */
  readonly "rois.system.disconnect": { params: NoParams; result: ReturnResult };
  /** Ask which engines and components exist. */
  readonly "rois.system.get_profile": { params: ConditionParams; result: ProfileResult };
  /** Ask more about a fault. */
  readonly "rois.system.get_error_detail": { params: ErrorDetailParams; result: ResultsResult };
  /** Ask for the components that meet a condition. */
  readonly "rois.command.search": { params: ConditionParams; result: SearchResult };
  /** Reserve a component. */
  readonly "rois.command.bind": { params: ComponentParams; result: ReturnResult };
  /** Reserve one that meets a condition. */
  readonly "rois.command.bind_any": { params: ConditionParams; result: ReferenceResult };
  /** Give a component back. */
  readonly "rois.command.release": { params: ComponentParams; result: ReturnResult };
  /** Ask for its parameters. */
  readonly "rois.command.get_parameter": { params: ComponentParams; result: ParametersResult };
  /** Change its parameters. */
  readonly "rois.command.set_parameter": { params: SetParameterParams; result: SetParameterResult };
  /** Start a sequence of commands. */
  readonly "rois.command.execute": { params: ExecuteParams; result: ReturnResult };
  /** Ask what a command gave. */
  readonly "rois.command.get_command_result": { params: CommandResultParams; result: ResultsResult };
  /** Ask a component something. */
  readonly "rois.query.query": { params: QueryParams; result: ResultsResult };
  /** Be told of an event. */
  readonly "rois.event.subscribe": { params: SubscribeParams; result: SubscribeResult };
  /** Be told of it no more. */
  readonly "rois.event.unsubscribe": { params: UnsubscribeParams; result: ReturnResult };
  /** Ask what an event tells. */
  readonly "rois.event.get_event_detail": { params: DetailParams; result: ResultsResult };
  /** Say and ask which extensions are spoken. */
  readonly "openrois.hello": { params: HelloParams; result: HelloResult };
  /** Show a new token before the old one ends. */
  readonly "openrois.auth.refresh": { params: AuthRefreshParams; result: AuthRefreshResult };
  /** Connect a stream. */
  readonly "rois.stream.connect_stream": { params: ConnectStreamParams; result: ConnectStreamResult };
  /** End a stream. */
  readonly "rois.stream.disconnect_stream": { params: StreamParams; result: ReturnResult };
  /** Pause a stream. */
  readonly "rois.stream.suspend_stream": { params: StreamParams; result: ReturnResult };
  /** Go on with a stream. */
  readonly "rois.stream.resume_stream": { params: StreamParams; result: ReturnResult };
  /** Ask what a stream does. */
  readonly "rois.stream.query_stream_status": { params: StreamParams; result: StreamStatusResult };
  /** Say how long what arrives of a stream waits here until it is played. */
  readonly "rois.stream.report_playout": { params: ReportPlayoutParams; result: ReturnResult };
  /** Say all that what is sent here may be used for from now on. */
  readonly "rois.stream.set_consent": { params: SetConsentParams; result: SetConsentResult };
  /** Ask which engines there are, page by page. */
  readonly "openrois.directory.list": { params: DirectoryListParams; result: DirectoryListResult };
  /** Ask for some engines. */
  readonly "openrois.directory.read": { params: DirectoryReadParams; result: DirectoryReadResult };
  /** Ask for the profiles of some components. */
  readonly "openrois.directory.profiles": { params: DirectoryProfilesParams; result: DirectoryProfilesResult };
  /** Ask who holds a component. */
  readonly "openrois.lease.query": { params: LeaseParams; result: LeaseResult };
  /** Ask its holder for it. */
  readonly "openrois.lease.request": { params: LeaseParams; result: LeaseRequestResult };
  /** Wait for it no more. */
  readonly "openrois.lease.leave": { params: LeaseParams; result: ReturnResult };
  /** Let who asks have it. */
  readonly "openrois.lease.grant": { params: LeaseRequestParams; result: ReturnResult };
  /** Keep it. */
  readonly "openrois.lease.decline": { params: LeaseRequestParams; result: ReturnResult };
  /** Take it from its holder. */
  readonly "openrois.lease.take": { params: LeaseParams; result: LeaseResult };
  /** Take it for a time. */
  readonly "openrois.lease.borrow": { params: LeaseBorrowParams; result: LeaseResult };
  /** Give its part back. */
  readonly "openrois.lease.give_back": { params: LeaseParams; result: ReturnResult };
  /** Ask for a resume token. */
  readonly "openrois.lease.token": { params: NoParams; result: LeaseTokenResult };
  /** Go on with a lost session. */
  readonly "openrois.lease.resume": { params: ResumeParams; result: ResumeResult };
  /** Stop all that acts on an engine. */
  readonly "openrois.stop_all": { params: StopAllParams; result: StopAllResult };
  /** Hand what a person has stopped back to programs. */
  readonly "openrois.lease.release_stop": { params: ReleaseStopParams; result: ReturnResult };
  /** Answer an engine's offer. */
  readonly "signaling.answer": { params: Answer; result: ReturnResult };
  /** Tell an engine of a candidate. */
  readonly "signaling.candidate": { params: Candidate; result: ReturnResult };
  /** Ask for a new peer connection. */
  readonly "signaling.restart": { params: Restart; result: ReturnResult };
  /** Ask which servers help to connect. */
  readonly "signaling.ice_servers": { params: NoParams; result: IceServersResult };
}

export type MethodName = keyof Methods;

/** Params of every notification that an application may get. */
export interface Notifications {
  /** An engine or a component has a fault. */
  readonly "rois.system.notify_error": ErrorNotification;
  /** The engines or components are others now. */
  readonly "rois.system.profile_changed": NoParams;
  /** A command has ended. */
  readonly "rois.command.completed": Completed;
  /** An event happened. */
  readonly "rois.event.notify_event": EventNotification;
  /** Here some events and errors were dropped: the application reads too slowly. */
  readonly "openrois.events_dropped": EventsDroppedNotification;
  /** The token ends soon, and the connection with it. */
  readonly "openrois.auth.expiring": AuthExpiringNotification;
  /** Why the message right behind this one, a reply or `completed`, says something else than OK. */
  readonly "openrois.reason": ReasonNotification;
  /** A stream does something else now. */
  readonly "rois.stream.notify_stream_status": StreamStatusNotification;
  /** Engines came, changed or have gone; in the place of `rois.system.profile_changed`. */
  readonly "openrois.directory.changed": DirectoryChangedNotification;
  /** A component has another holder, or another queue. */
  readonly "openrois.lease.changed": LeaseChangedNotification;
  /** Another application asks for a component that this one holds. */
  readonly "openrois.lease.requested": LeaseRequestedNotification;
  /** The holder keeps the component, or does not answer. */
  readonly "openrois.lease.declined": LeaseDeclinedNotification;
  /** Who has asked for the component does not any more. */
  readonly "openrois.lease.withdrawn": LeaseWithdrawnNotification;
  /** A person has stopped an engine for programs, or handed it back. */
  readonly "openrois.lease.stopped": StoppedNotification;
  /** An engine offers a peer connection. */
  readonly "signaling.offer": Offer;
  /** An engine has a candidate. */
  readonly "signaling.candidate": Candidate;
  /** An engine says when what it sends was captured. */
  readonly "signaling.capture_clocks": CaptureClocks;
  /** An engine has ended a peer connection. */
  readonly "signaling.bye": Bye;
}

export type NotificationName = keyof Notifications;
