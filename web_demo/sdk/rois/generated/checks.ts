/** What is checked of each message that comes in. Written by `make generate`; edits are lost. */

import { identity, integer, itself, list, map, object, oneOf, optional, orNull, text } from "../check.ts";
import type { Check } from "../check.ts";
import type { MethodName, NotificationName } from "./methods.ts";
import { CompletedStatus, ComponentFunction, Direction, ErrorType, LeaseState, MediaKind, ReturnCode, StreamStatus } from "./types.ts";

const isReturnCode: Check = oneOf(ReturnCode);

const isReturnResult: Check = object({
  return_code: isReturnCode,
});

const isRoISIdentifier: Check = object({
  code: text,
  authority: optional(text),
  codebook_ref: optional(text),
  version: optional(text),
});

const isParameterProfile: Check = object({
  name: text,
  data_type_ref: isRoISIdentifier,
  default_value: optional(text),
  description: optional(text),
});

const isHRIEngineProfile: Check = object({
  identifier: isRoISIdentifier,
  sub_profiles: optional(list(itself(() => isHRIEngineProfile))),
  component_ids: optional(list(text)),
  parameter_profiles: optional(list(isParameterProfile)),
});

const isComponentFunction: Check = oneOf(ComponentFunction);

const isCommandMessageProfile: Check = object({
  name: text,
  results: optional(list(isParameterProfile)),
  arguments: optional(list(isParameterProfile)),
  timeout: optional(orNull(integer)),
});

const isQueryMessageProfile: Check = object({
  name: text,
  results: optional(list(isParameterProfile)),
});

const isEventMessageProfile: Check = object({
  name: text,
  results: optional(list(isParameterProfile)),
});

const isHRIComponentProfile: Check = object({
  identifier: isRoISIdentifier,
  name: text,
  function: optional(orNull(isComponentFunction)),
  part: optional(orNull(text)),
  sub_component_profiles: optional(list(text)),
  command_profiles: optional(list(isCommandMessageProfile)),
  query_profiles: optional(list(isQueryMessageProfile)),
  event_profiles: optional(list(isEventMessageProfile)),
  parameter_profiles: optional(list(isParameterProfile)),
});

const isProfileResult: Check = object({
  return_code: isReturnCode,
  profile: optional(orNull(isHRIEngineProfile)),
  component_profiles: optional(map(isHRIComponentProfile)),
});

const isResult: Check = object({
  name: text,
  data_type_ref: text,
  value: text,
});

const isResultsResult: Check = object({
  return_code: isReturnCode,
  results: optional(list(isResult)),
});

const isSearchResult: Check = object({
  return_code: isReturnCode,
  component_ref_list: optional(list(text)),
});

const isReferenceResult: Check = object({
  return_code: isReturnCode,
  component_ref: optional(text),
});

const isParameter: Check = object({
  name: text,
  data_type_ref: text,
  value: text,
});

const isParametersResult: Check = object({
  return_code: isReturnCode,
  parameters: optional(list(isParameter)),
});

const isSetParameterResult: Check = object({
  return_code: isReturnCode,
  command_id: optional(text),
});

const isSubscribeResult: Check = object({
  return_code: isReturnCode,
  subscribe_id: optional(text),
});

const isStopped: Check = object({
  engine_id: text,
  by: text,
  stop_id: optional(text),
});

const isHelloResult: Check = object({
  return_code: isReturnCode,
  version: optional(text),
  extensions: optional(list(text)),
  engines: optional(list(text)),
  client_id: optional(text),
  instance: optional(text),
  epoch: optional(integer),
  stopped: optional(list(isStopped)),
});

const isAuthRefreshResult: Check = object({
  return_code: isReturnCode,
  seconds: optional(integer),
});

const isConnectStreamResult: Check = object({
  return_code: isReturnCode,
  stream_id: optional(text),
});

const isStreamStatus: Check = oneOf(StreamStatus);

const isStreamStatusResult: Check = object({
  return_code: isReturnCode,
  status: optional(isStreamStatus),
});

const isSetConsentResult: Check = object({
  return_code: isReturnCode,
  visitor_ref: optional(text),
});

const isComponentEntry: Check = object({
  component_ref: text,
  component_type: text,
  function: optional(orNull(isComponentFunction)),
  profile_version: text,
});

const isEngineEntry: Check = object({
  engine_id: text,
  parent_id: text,
  version: text,
  extensions: optional(list(text)),
  components: optional(list(isComponentEntry)),
  identifier: optional(orNull(isRoISIdentifier)),
  parameter_profiles: optional(list(isParameterProfile)),
});

const isDirectoryListResult: Check = object({
  return_code: isReturnCode,
  engines: optional(list(isEngineEntry)),
  next: optional(text),
  count: optional(integer),
});

const isDirectoryReadResult: Check = object({
  return_code: isReturnCode,
  engines: optional(list(isEngineEntry)),
  left: optional(list(text)),
});

const isDirectoryProfilesResult: Check = object({
  return_code: isReturnCode,
  profiles: optional(map(isHRIComponentProfile)),
  left: optional(list(text)),
});

const isLeaseState: Check = oneOf(LeaseState);

const isLeaseStatus: Check = object({
  component_ref: optional(text),
  state: optional(isLeaseState),
  holder: optional(text),
  epoch: optional(integer),
  waiting: optional(integer),
  position: optional(integer),
  stopped_by: optional(text),
  stop_id: optional(text),
  part: optional(text),
  lender: optional(text),
  return_ms: optional(integer),
  return_position: optional(integer),
});

const isLeaseResult: Check = object({
  return_code: isReturnCode,
  lease: optional(orNull(isLeaseStatus)),
});

const isLeaseRequestResult: Check = object({
  return_code: isReturnCode,
  lease: optional(orNull(isLeaseStatus)),
  request_id: optional(text),
});

const isLeaseTokenResult: Check = object({
  return_code: isReturnCode,
  token: optional(text),
  grace_ms: optional(integer),
});

const isLease: Check = object({
  component_ref: text,
  epoch: integer,
});

const isResumeResult: Check = object({
  return_code: isReturnCode,
  token: optional(text),
  grace_ms: optional(integer),
  leases: optional(list(isLease)),
  forgotten: optional(list(text)),
});

const isStopAllResult: Check = object({
  return_code: isReturnCode,
  stopped: optional(list(text)),
  failed: optional(list(text)),
});

const isIceServer: Check = object({
  urls: list(text),
  username: optional(orNull(text)),
  credential: optional(orNull(text)),
});

const isIceServersResult: Check = object({
  return_code: isReturnCode,
  ice_servers: optional(list(isIceServer)),
  ttl: optional(integer),
});

const isErrorType: Check = oneOf(ErrorType);

const isErrorNotification: Check = object({
  error_id: text,
  error_type: isErrorType,
});

const isNoParams: Check = object({});

const isCompletedStatus: Check = oneOf(CompletedStatus);

const isCompleted: Check = object({
  command_id: text,
  status: isCompletedStatus,
});

const isEventNotification: Check = object({
  event_id: text,
  event_type: text,
  subscribe_id: text,
  expire: optional(text),
  results: optional(list(isResult)),
});

const isEventsDroppedNotification: Check = object({
  count: integer,
});

const isAuthExpiringNotification: Check = object({
  seconds: integer,
});

const isReasonNotification: Check = object({
  request_id: optional(orNull(identity)),
  command_id: optional(orNull(text)),
  reason: text,
});

const isStreamStatusNotification: Check = object({
  stream_id: text,
  component_ref: text,
  status: isStreamStatus,
  timestamp: text,
});

const isDirectoryChangedNotification: Check = object({
  changed: optional(list(text)),
  gone: optional(list(text)),
  unnamed: optional(integer),
});

const isLeaseChangedNotification: Check = object({
  component_ref: optional(text),
  state: optional(isLeaseState),
  holder: optional(text),
  epoch: optional(integer),
  waiting: optional(integer),
  position: optional(integer),
  stopped_by: optional(text),
  stop_id: optional(text),
  part: optional(text),
  lender: optional(text),
  return_ms: optional(integer),
  return_position: optional(integer),
  reason: optional(text),
});

const isLeaseRequestedNotification: Check = object({
  component_ref: text,
  request_id: text,
  subject: text,
  answer_ms: integer,
});

const isLeaseDeclinedNotification: Check = object({
  component_ref: text,
  request_id: text,
  reason: text,
});

const isLeaseWithdrawnNotification: Check = object({
  component_ref: text,
  request_id: text,
});

const isStoppedNotification: Check = object({
  engine_id: text,
  by: optional(text),
  reason: optional(text),
  stop_id: optional(text),
});

const isMediaKind: Check = oneOf(MediaKind);

const isDirection: Check = oneOf(Direction);

const isStreamSection: Check = object({
  mid: text,
  stream_id: text,
  component_ref: text,
  kind: isMediaKind,
  direction: isDirection,
});

const isOffer: Check = object({
  peer_id: text,
  generation: integer,
  sdp: text,
  streams: list(isStreamSection),
  replaces: optional(orNull(text)),
});

const isCandidate: Check = object({
  peer_id: text,
  generation: integer,
  candidate: orNull(text),
  sdp_mid: optional(orNull(text)),
  sdp_m_line_index: optional(orNull(integer)),
});

const isSenderClock: Check = object({
  mid: text,
  ssrc: integer,
  clock_rate: integer,
  rtp_origin: integer,
  wall: integer,
});

const isCaptureClocks: Check = object({
  peer_id: text,
  senders: list(isSenderClock),
});

const isBye: Check = object({
  peer_id: text,
  reason: text,
});

/** The result of each method. */
export const RESULTS: { readonly [Name in MethodName]: Check } = {
  "rois.system.connect": isReturnResult,
  "rois.system.disconnect": isReturnResult,
  "rois.system.get_profile": isProfileResult,
  "rois.system.get_error_detail": isResultsResult,
  "rois.command.search": isSearchResult,
  "rois.command.bind": isReturnResult,
  "rois.command.bind_any": isReferenceResult,
  "rois.command.release": isReturnResult,
  "rois.command.get_parameter": isParametersResult,
  "rois.command.set_parameter": isSetParameterResult,
  "rois.command.execute": isReturnResult,
  "rois.command.get_command_result": isResultsResult,
  "rois.query.query": isResultsResult,
  "rois.event.subscribe": isSubscribeResult,
  "rois.event.unsubscribe": isReturnResult,
  "rois.event.get_event_detail": isResultsResult,
  "openrois.hello": isHelloResult,
  "openrois.auth.refresh": isAuthRefreshResult,
  "rois.stream.connect_stream": isConnectStreamResult,
  "rois.stream.disconnect_stream": isReturnResult,
  "rois.stream.suspend_stream": isReturnResult,
  "rois.stream.resume_stream": isReturnResult,
  "rois.stream.query_stream_status": isStreamStatusResult,
  "rois.stream.report_playout": isReturnResult,
  "rois.stream.set_consent": isSetConsentResult,
  "openrois.directory.list": isDirectoryListResult,
  "openrois.directory.read": isDirectoryReadResult,
  "openrois.directory.profiles": isDirectoryProfilesResult,
  "openrois.lease.query": isLeaseResult,
  "openrois.lease.request": isLeaseRequestResult,
  "openrois.lease.leave": isReturnResult,
  "openrois.lease.grant": isReturnResult,
  "openrois.lease.decline": isReturnResult,
  "openrois.lease.take": isLeaseResult,
  "openrois.lease.borrow": isLeaseResult,
  "openrois.lease.give_back": isReturnResult,
  "openrois.lease.token": isLeaseTokenResult,
  "openrois.lease.resume": isResumeResult,
  "openrois.stop_all": isStopAllResult,
  "openrois.lease.release_stop": isReturnResult,
  "signaling.answer": isReturnResult,
  "signaling.candidate": isReturnResult,
  "signaling.restart": isReturnResult,
  "signaling.ice_servers": isIceServersResult,
};

/** The params of each notification. */
export const NOTIFICATIONS: { readonly [Name in NotificationName]: Check } = {
  "rois.system.notify_error": isErrorNotification,
  "rois.system.profile_changed": isNoParams,
  "rois.command.completed": isCompleted,
  "rois.event.notify_event": isEventNotification,
  "openrois.events_dropped": isEventsDroppedNotification,
  "openrois.auth.expiring": isAuthExpiringNotification,
  "openrois.reason": isReasonNotification,
  "rois.stream.notify_stream_status": isStreamStatusNotification,
  "openrois.directory.changed": isDirectoryChangedNotification,
  "openrois.lease.changed": isLeaseChangedNotification,
  "openrois.lease.requested": isLeaseRequestedNotification,
  "openrois.lease.declined": isLeaseDeclinedNotification,
  "openrois.lease.withdrawn": isLeaseWithdrawnNotification,
  "openrois.lease.stopped": isStoppedNotification,
  "signaling.offer": isOffer,
  "signaling.candidate": isCandidate,
  "signaling.capture_clocks": isCaptureClocks,
  "signaling.bye": isBye,
};
