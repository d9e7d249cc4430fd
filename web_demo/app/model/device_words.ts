/** What a microphone or camera is doing, in words. Pure. */

import type { StreamStatus } from "../../sdk/index.ts";
import { plainReason } from "./plain_words.ts";
import type { CaptureProblem, Problem } from "../../sdk/media/index.ts";

export interface DeviceWords {
  readonly state: "off" | "asking" | "trouble" | "waiting" | "on" | "held";
  readonly text: string;
}

/**
 * @param on the device is in use; what it gives may have nowhere to go
 * @param used what the avatar does with it for this page, such as `looked at`; empty for nothing
 */
export function deviceWords(
  on: boolean,
  asking: boolean,
  status: StreamStatus | null,
  failed: boolean,
  used = "",
): DeviceWords {
  if (!on) {
    if (asking) return { state: "asking", text: "Asking for permission" };
    return failed ? { state: "trouble", text: "Not available" } : { state: "off", text: "Off" };
  }
  if (status === "STREAMING_RUNNING") return { state: "on", text: used === "" ? "Sent" : `Sent, ${used}` };
  if (status === "STREAMING_SUSPENDED") return { state: "held", text: "Paused by the body" };
  return { state: "waiting", text: "Connecting" };
}

/** Says what leaves this machine; empty for nothing. */
export function sendingWords(microphone: boolean, camera: boolean): string {
  if (microphone && camera) return "Microphone and camera are on";
  return microphone ? "Microphone is on" : camera ? "Camera is on" : "";
}

/** Returns the sentence about what is nearest to the user; null when nothing is wrong. */
export function deviceTrouble(device: CaptureProblem | null, stream: Problem | null): string | null {
  if (device) return device.detail;
  switch (stream?.kind) {
    case "no-media":
      return "Nothing gets through to the body. Another way through the network is being looked for.";
    case "no-streaming":
      return "This gateway cannot stream. Run an OpenRoIS gateway of this version.";
    case "unsupported":
    case "refused": {
      const why = plainReason(stream.detail);
      return `The body does not take it${why && `: ${why}`}.`;
    }
    default:
      return null;
  }
}
