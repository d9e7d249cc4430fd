/** What a `MediaReceiver` is given. */

import type { Notification } from "../jsonrpc/peer.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { ConnectionState } from "../rois/connection.ts";
import type { MediaKind } from "../rois/generated/types.ts";
import type { Call } from "../rois/link.ts";
import type { Devices } from "./capture.ts";
import type { CreatePeerConnection } from "./peer.ts";
import type { EncodingLimits } from "./stream.ts";

/** What a `Client` offers to the receiver. */
export interface MediaLink {
  readonly state: ConnectionState;
  readonly call: Call;
  on(name: "state", listener: (state: ConnectionState) => void): () => void;
  on(name: "notification", listener: (notification: Notification) => void): () => void;
}

export interface ReceiverOptions {
  readonly backoff?: BackoffOptions;
  readonly createPeerConnection?: CreatePeerConnection;
  /** What this application can decode, best first. */
  readonly codecs?: (kind: MediaKind) => string[];
  /** Microphones and cameras; replaced in tests. */
  readonly devices?: Devices;
  /** Have data channels with the streams, for a `Teleoperation`. */
  readonly input?: boolean;
}

/** How a stream of this application's own is connected. */
export interface SendingOptions {
  /** `sendrecv` also hears what comes back; for sound only. */
  readonly direction?: "sendonly" | "sendrecv";
  readonly limits?: EncodingLimits;
  /** What else is wanted of the device. */
  readonly constraints?: MediaTrackConstraints;
}
