/**
 * The OpenRoIS SDK: RoIS 2.0 over JSON-RPC, in a browser and in Node. The streams that RoIS controls are received with
 * `openrois/media`, in a browser.
 */

export type { BackoffOptions } from "./rois/backoff.ts";
export { Body } from "./rois/body.ts";
export type { AnyComponentClass } from "./rois/body.ts";
export { bodiesIn, bodiesOf } from "./rois/body_directory.ts";
export type { BodyComponent, BodyInfo, BodyPart, BodyProfile } from "./rois/body_directory.ts";
export type { BodyLoss, BodyOptions } from "./rois/reserving.ts";
export type { BindingClaim, Claim, LentClaim, LostClaim, SubscriptionClaim } from "./rois/claims.ts";
export { Client } from "./rois/client.ts";
export type { Command, Concurrent, Profile, Step } from "./rois/client.ts";
export { ComponentEvent, ComponentProxy } from "./rois/component.ts";
export type { ComponentClass, Settable } from "./rois/component.ts";
export { Control } from "./rois/control.ts";
export type { ControlEvents } from "./rois/control.ts";
export { and, escapeLike, like, onlyComponent, quote, where } from "./rois/conditions.ts";
export type { ConnectionOptions, ConnectionState } from "./rois/connection.ts";
export { codeOf, componentType, componentUrn, componentsByEngine, engineOf } from "./rois/discovery.ts";
export { CommandFailed, InvalidMessage, RoISError, ValueError } from "./rois/errors.ts";
export type {
  Call,
  CallName,
  ClientEvents,
  ClientOptions,
  Ended,
  Params,
  ResultOf,
  RoISEvent,
} from "./rois/link.ts";
export { decode, encode, resultValue } from "./rois/payload.ts";
export type { ProfileChange } from "./rois/profile_change.ts";
export type { Types } from "./rois/payload.ts";
export type { IsStopped } from "./rois/stops.ts";
export type { Subscription } from "./rois/subscriptions.ts";
export { decodeValue, encodeValue } from "./rois/values.ts";
export type { Value, Writable } from "./rois/values.ts";
export * from "./rois/generated/components.ts";
export type * from "./rois/extension_methods.ts";
export type * from "./rois/generated/methods.ts";
export * from "./rois/generated/types.ts";
export { ConnectionLost, RequestTimeout, RpcError } from "./jsonrpc/session.ts";
export type { SocketLike, Traffic } from "./jsonrpc/session.ts";
export type { Json, JsonObject, Notification } from "./jsonrpc/peer.ts";
