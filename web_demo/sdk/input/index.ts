/** Input of keyboard, mouse, touch and gamepad, sent to an avatar. */

export type { CollectorOptions } from "./collector.ts";
export { Teleoperation } from "./teleoperation.ts";
export type { InputMedia, TeleoperationEvents } from "./teleoperation.ts";
