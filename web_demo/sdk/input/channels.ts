/** The two data channels of one peer connection. */

import { readEngineMessage } from "./messages.ts";
import type { EngineMessage } from "./messages.ts";

/** Most bytes waiting to be sent: the newest state is worth more than older ones. */
const UNSENT = 2048;
const UNSENT_CHANGES = 16_384;

export class InputChannels {
  /** Is called with each message of the engine. */
  onMessage: (message: EngineMessage) => void = () => undefined;
  readonly #input: RTCDataChannel;
  readonly #control: RTCDataChannel;

  constructor(connection: RTCPeerConnection) {
    this.#input = connection.createDataChannel("input", {
      negotiated: true,
      id: 0,
      ordered: false,
      maxRetransmits: 0,
    });
    this.#control = connection.createDataChannel("control", { negotiated: true, id: 1 });
    this.#control.onmessage = ({ data }) => {
      const message = readEngineMessage(data);
      if (message) this.onMessage(message);
    };
  }

  /** Whether both channels are open. */
  get open(): boolean {
    return this.#input.readyState === "open" && this.#control.readyState === "open";
  }

  /** Sends the present state; false when earlier states still wait to be sent. */
  sendState(text: string): boolean {
    if (!this.open || this.#input.bufferedAmount > UNSENT) return false;
    this.#input.send(text);
    return true;
  }

  /** Sends a change; false when too many wait. */
  sendChange(text: string): boolean {
    if (!this.open || this.#control.bufferedAmount > UNSENT_CHANGES) return false;
    this.#control.send(text);
    return true;
  }
}
