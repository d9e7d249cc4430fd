/** Input of keyboard, mouse, touch and gamepad, and speech, sent to an avatar. */

export type { CollectorOptions } from "./collector.ts";
export type { SpeechRate, Spoken } from "./speech_messages.ts";
export { SpeechStream } from "./speech_stream.ts";
export type { SpeechStreamEvents } from "./speech_stream.ts";
export { Teleoperation } from "./teleoperation.ts";
export type { InputMedia, TeleoperationEvents } from "./teleoperation.ts";
