/** The data channels of one peer connection. */

import { readEngineMessage } from "./messages.ts";
import type { EngineMessage } from "./messages.ts";
import { readSpeechTold } from "./speech_messages.ts";
import type { SpeechTold } from "./speech_messages.ts";

/** Most bytes waiting to be sent: the newest state is worth more than older ones. */
const UNSENT = 2048;
const UNSENT_CHANGES = 16_384;

export class InputChannels {
  /** Is called with each message of the engine. */
  onMessage: (message: EngineMessage) => void = () => undefined;
  readonly #input: RTCDataChannel;
  readonly #control: RTCDataChannel;
  readonly #speech: RTCDataChannel;
  readonly #speeches = new Map<
    number,
    { readonly told: (told: SpeechTold) => void; readonly lost: () => void }
  >();

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
    this.#speech = connection.createDataChannel("speech", { negotiated: true, id: 2 });
    this.#speech.onmessage = ({ data }) => {
      const told = readSpeechTold(data);
      if (!told) return;
      const speech = this.#speeches.get(told.utterance);
      if (told.event === "finished" || told.event === "refused") this.#speeches.delete(told.utterance);
      speech?.told(told);
    };
    this.#speech.onclose = () => {
      const lost = [...this.#speeches.values()];
      this.#speeches.clear();
      for (const speech of lost) speech.lost();
    };
  }

  /** Whether all channels are open. */
  get open(): boolean {
    return [this.#input, this.#control, this.#speech].every(({ readyState }) => readyState === "open");
  }

  /** Calls back with what the body tells of a speech, until it is over or the channels are closed. */
  listenToSpeech(utterance: number, told: (told: SpeechTold) => void, lost: () => void): void {
    this.#speeches.set(utterance, { told, lost });
  }

  /** Sends a frame or a message of speech; it is lost when the channels are not open. */
  speak(data: string | ArrayBuffer): void {
    if (!this.open) return;
    if (typeof data === "string") this.#speech.send(data);
    else this.#speech.send(data);
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
