/** The OpenRoIS SDK for the browser: RoIS over JSON-RPC, and the streams that RoIS controls over WebRTC. */

export { Actuator } from "./rois/actuator.ts";
export { RoISClient } from "./rois/client.ts";
export type { ClientEvents, ClientOptions } from "./rois/client.ts";
export { gatewayUrl } from "./rois/connection.ts";
export type { ConnectionOptions, ConnectionState } from "./rois/connection.ts";
export { componentType, componentsByEngine, engineOf, onlyComponent } from "./rois/discovery.ts";
export type { Subscription } from "./rois/subscriptions.ts";
export { RoISError, listValue, resultValue } from "./rois/types.ts";
export type * from "./rois/types.ts";
export { ConnectionLost, RequestTimeout, RpcError } from "./jsonrpc/session.ts";
export type { SocketLike, Traffic } from "./jsonrpc/session.ts";
export type { Json, JsonObject } from "./jsonrpc/peer.ts";
export { SAME_CLOCK, isLoopback, measureOffset } from "./media/clock_offset.ts";
export type { ClockOffset } from "./media/clock_offset.ts";
export { decodableCodecs } from "./media/codecs.ts";
export type { MediaKind } from "./media/codecs.ts";
export { FrameWatch, LastingPicture, StampReader } from "./media/frames.ts";
export type { PresentedFrame, StampReading } from "./media/frames.ts";
export { MediaReceiver } from "./media/receiver.ts";
export type { MediaLink, ReceiverOptions } from "./media/receiver.ts";
export type { Desire, Problem } from "./media/reconciler.ts";
export { RecentMedian } from "./media/statistics.ts";
export type { Figures } from "./media/statistics.ts";
export type { Stamp } from "./media/stamp.ts";
export type { RemoteStream, StreamEvents } from "./media/stream.ts";
