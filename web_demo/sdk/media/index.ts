/** The streams that RoIS controls, received and sent over WebRTC in a browser. */

export { SAME_CLOCK, isLoopback, measureOffset, wallNow } from "./engine_clock.ts";
export type { ClockOffset } from "./engine_clock.ts";
export type { CaptureProblem, Devices } from "./capture.ts";
export { decodableCodecs, encodableCodecs } from "./codecs.ts";
export { FrameWatch, LastingPicture } from "./frames.ts";
export type { PresentedFrame } from "./frames.ts";
export type { LocalStream } from "./local_stream.ts";
export { MediaReceiver } from "./receiver.ts";
export type { MediaLink, ReceiverOptions, SendingOptions } from "./receiver_options.ts";
export type { Desire, Problem } from "./reconciler.ts";
export { RecentMedian } from "./statistics.ts";
export type { Figures } from "./statistics.ts";
export { SpeechStream, Teleoperation } from "../input/index.ts";
export type { CollectorOptions, InputMedia, TeleoperationEvents } from "../input/index.ts";
export type { SpeechRate, SpeechStreamEvents, Spoken } from "../input/index.ts";
export type { ControlledStream, EncodingLimits, RemoteStream, StreamEvents } from "./stream.ts";
