/** The two data channels of one peer connection. */

import { readTold } from "./messages.ts";
import type { Told } from "./messages.ts";

/** Bytes that may wait to be sent; the newest state is worth more than all before it. */
const UNSENT = 2048;
const UNSENT_CHANGES = 16_384;

export class InputChannels {
  /** Hears what the engine says. */
  onTold: (told: Told) => void = () => undefined;
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
      const told = readTold(data);
      if (told) this.onTold(told);
    };
  }

  /** Messages can be sent in both. */
  get open(): boolean {
    return this.#input.readyState === "open" && this.#control.readyState === "open";
  }

  /** Sends all that is held now; false when states before it still wait, and it is of no use to add to them. */
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
