/** Options of a `MediaReceiver`. */

import type { Notification } from "../jsonrpc/peer.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { ConnectionState } from "../rois/connection.ts";
import type { MediaKind, Purpose } from "../rois/generated/types.ts";
import type { Call } from "../rois/link.ts";
import type { Devices } from "./capture.ts";
import type { CreatePeerConnection } from "./peer.ts";
import type { EncodingLimits } from "./stream.ts";

/** The part of a `Client` that the receiver needs. */
export interface MediaLink {
  readonly state: ConnectionState;
  readonly call: Call;
  on(name: "state", listener: (state: ConnectionState) => void): () => void;
  on(name: "notification", listener: (notification: Notification) => void): () => void;
}

export interface ReceiverOptions {
  readonly backoff?: BackoffOptions;
  readonly createPeerConnection?: CreatePeerConnection;
  /** Codecs that this application decodes, best first. */
  readonly codecs?: (kind: MediaKind) => string[];
  /** Microphones and cameras; replaced in tests. */
  readonly devices?: Devices;
  /** Have data channels with the streams, for a `Teleoperation` or a `SpeechStream`. */
  readonly input?: boolean;
}

/** How a stream of this application's own is connected. */
export interface SendingOptions {
  /** `sendrecv` also receives; for sound only. */
  readonly direction?: "sendonly" | "sendrecv";
  readonly limits?: EncodingLimits;
  /** All that it may be used for. Nothing is said by default, which a body takes for live and recognition. */
  readonly consent?: readonly Purpose[];
  /** Further constraints of the device. */
  readonly constraints?: MediaTrackConstraints;
}
