/** Speech as sound: what an application speaks through a body, pushed at the pace at which it is heard. */

import { Emitter } from "../jsonrpc/events.ts";
import type { Client } from "../rois/client.ts";
import { onlyComponent } from "../rois/conditions.ts";
import { engineOf } from "../rois/discovery.ts";
import type { InputChannels } from "./channels.ts";
import { Credit, FRAME_SAMPLES, packFrame, pcm16 } from "./speech_messages.ts";
import type { SpeechRate, SpeechTold, Spoken } from "./speech_messages.ts";
import type { InputMedia } from "./teleoperation.ts";

const LOST = "the connection over which it was spoken was lost";
const CLEARED = "the speech was cleared before this was spoken";

const NOTHING: Spoken = { seconds: 0, reason: "" };

/** What is pushed up to the next `finish`; what of it waits to be sent is dropped with what was interrupted before it. */
interface Pushes {
  interrupted: string;
}

/** Number of the last speech of the page: each has a greater one than those before. */
let newest = 0;

export interface SpeechStreamEvents {
  /** The first sound of a speech is heard; the value is its id in the events of SpeechProgress. */
  started: string;
  /** All that was pushed was heard, the value in seconds, and there is silence. */
  starved: number;
  /** A speech is over. */
  finished: Spoken;
}

export class SpeechStream {
  readonly componentRef: string;
  readonly rate: SpeechRate;
  readonly #client: Client;
  readonly #media: InputMedia;
  readonly #events = new Emitter<SpeechStreamEvents>();
  readonly #spoken = new Map<number, Utterance>();
  /** Speeches that were lost with their channels: the body may wait for the rest of them, and others behind them. */
  readonly #lost: Utterance[] = [];
  #current: Utterance | null = null;
  #latest: Utterance | null = null;
  #turn: Promise<unknown> = Promise.resolve();
  #pushes: Pushes = { interrupted: "" };
  #clears = 0;
  #endStops: () => void = () => undefined;

  /**
   * @param media a `MediaReceiver` made with `input: true`, with a stream of the body
   * @param rate samples a second of what will be pushed
   */
  constructor(client: Client, media: InputMedia, componentRef: string, rate: SpeechRate = 48_000) {
    this.#client = client;
    this.#media = media;
    this.componentRef = componentRef;
    this.rate = rate;
  }

  on<Name extends keyof SpeechStreamEvents>(
    name: Name,
    listener: (value: SpeechStreamEvents[Name]) => void,
  ): () => void {
    return this.#events.on(name, listener);
  }

  /**
   * Binds the component. Where the body is stopped, what was pushed up to then is not spoken any more.
   *
   * @throws RoISError (OUT_OF_RESOURCES: another application has it) | CommandFailed (ABORT: it was stopped meanwhile)
   */
  async start(): Promise<void> {
    const client = this.#client;
    const bind = async (): Promise<void> => {
      await client.bind(this.componentRef);
      // Sound takes a shorter way than the binding: it must not arrive before the body knows of that.
      await client.query("streaming", onlyComponent(this.componentRef));
    };
    await client.control.unlessStopped(this.componentRef, bind, () => client.release(this.componentRef));
    this.#endStops();
    this.#endStops = client.on("stopped", (isStopped) => {
      if (isStopped(this.componentRef)) void this.clear();
    });
  }

  /** Silences the body, and gives the component back. */
  async stop(): Promise<void> {
    this.#endStops();
    await this.clear();
    await this.#client.release(this.componentRef);
  }

  /**
   * Speaks on, or begins a speech; resolves when all was sent, which is when less than a second of it waits to be heard.
   *
   * @param samples mono; floats are from -1 to 1
   * @param text what the speech that begins here says, for captions
   * @throws Error when the speech was interrupted, with the reason, or there is no connection to the body
   */
  push(samples: Int16Array | Float32Array, text = ""): Promise<void> {
    const sound = pcm16(samples);
    const [pushes, clears] = [this.#pushes, this.#clears];
    return this.#inTurn(async () => {
      const why = clears === this.#clears ? pushes.interrupted : CLEARED;
      if (why !== "") throw new Error(why);
      const utterance = this.#current ?? this.#begin(text);
      for (let first = 0; first < sound.length; first += FRAME_SAMPLES) {
        const reason = await utterance.push(sound.subarray(first, first + FRAME_SAMPLES));
        if (reason === null) continue;
        pushes.interrupted = reason;
        if (this.#pushes === pushes) this.#pushes = { interrupted: "" };
        if (this.#current === utterance) this.#current = null;
        throw new Error(reason);
      }
    });
  }

  /** Says when words of the present speech begin, in seconds; their sound may come before or after that. */
  addWords(words: readonly (readonly [text: string, start: number])[], text = ""): void {
    const utterance = this.#current ?? this.#begin(text);
    for (let first = 0; first < words.length; first += 20)
      utterance.say({
        event: "words",
        words: words.slice(first, first + 20).map(([word, start]) => [word, Math.round(start * 1000)]),
      });
  }

  /** Ends the present speech; resolves when it is over, heard or interrupted; without one, when the last one is. */
  async finish(): Promise<Spoken> {
    this.#pushes = { interrupted: "" };
    const utterance = await this.#inTurn(() => {
      const ended = this.#current;
      ended?.say({ event: "end" });
      this.#current = null;
      return Promise.resolve(ended);
    });
    return (utterance ?? this.#latest)?.over ?? NOTHING;
  }

  /**
   * Silences all that was pushed, at once, also what still waits to be sent; resolves to what was heard of the present
   * speech, or of the last one.
   */
  async clear(): Promise<Spoken> {
    this.#clears += 1;
    const cleared = [...this.#spoken.values()];
    for (const utterance of cleared) utterance.clear();
    this.#current = null;
    await Promise.all(cleared.map(({ over }) => over));
    return this.#latest?.over ?? NOTHING;
  }

  #begin(text: string): Utterance {
    const [channels] = this.#media.inputs(engineOf(this.componentRef));
    if (!channels) throw new Error(`there is no connection to ${this.componentRef} now`);
    for (const { number } of this.#lost.splice(0)) channels.sendChange(clearing(number));
    newest += 1;
    const utterance = new Utterance(newest, this.rate, channels, text);
    channels.listenToSpeech(
      utterance.number,
      (told) => this.#handle(utterance, told),
      () => {
        this.#lost.push(utterance);
        this.#handle(utterance, utterance.lost);
      },
    );
    this.#spoken.set(utterance.number, utterance);
    this.#current = this.#latest = utterance;
    return utterance;
  }

  #handle(utterance: Utterance, told: SpeechTold): void {
    utterance.handle(told);
    if (told.event === "started") this.#events.emit("started", told.speech_id);
    if (told.event === "starved") this.#events.emit("starved", told.position / 1000);
    if (!utterance.result || !this.#spoken.delete(utterance.number)) return;
    this.#events.emit("finished", utterance.result);
  }

  /** Lets pushes follow each other. */
  #inTurn<Result>(work: () => Promise<Result>): Promise<Result> {
    const done = this.#turn.then(work);
    this.#turn = done.catch(() => undefined);
    return done;
  }
}

const clearing = (utterance: number): string => JSON.stringify({ event: "clear", utterance });

/** One speech, from its first frame to its end. */
class Utterance {
  readonly number: number;
  readonly over: Promise<Spoken>;
  result: Spoken | null = null;
  readonly #rate: SpeechRate;
  readonly #credit: Credit;
  readonly #channels: InputChannels;
  #sequence = 0;
  #news: () => void = () => undefined;
  #end: (spoken: Spoken) => void = () => undefined;

  constructor(number: number, rate: SpeechRate, channels: InputChannels, text: string) {
    this.number = number;
    this.#rate = rate;
    this.#credit = new Credit(rate);
    this.#channels = channels;
    this.over = new Promise((resolve) => (this.#end = resolve));
    this.say({ event: "begin", format: "pcm16", rate, ...(text !== "" && { text }) });
  }

  /** What is known of it when its channels have closed. */
  get lost(): SpeechTold {
    const position = Math.round((1000 * this.#credit.played) / this.#rate);
    return { event: "finished", utterance: this.number, position, reason: LOST };
  }

  /** Sends samples as soon as there is credit; resolves to why it was interrupted, or null. */
  async push(samples: Int16Array): Promise<string | null> {
    while (!this.result && this.#credit.room < samples.length)
      await new Promise<void>((resolve) => (this.#news = resolve));
    if (this.result) return this.result.reason;
    this.#credit.sent += samples.length;
    this.#channels.speak(packFrame(this.number, this.#sequence, samples));
    this.#sequence += 1;
    return null;
  }

  say(body: object): void {
    if (!this.result) this.#channels.speak(JSON.stringify({ utterance: this.number, ...body }));
  }

  clear(): void {
    this.#channels.sendChange(clearing(this.number));
  }

  handle(told: SpeechTold): void {
    if (told.event === "credit") this.#credit.grant(told.samples, told.played);
    if (told.event === "finished" || told.event === "refused") {
      const seconds = told.event === "finished" ? told.position / 1000 : 0;
      this.result ??= { seconds, reason: told.reason ?? "" };
      this.#end(this.result);
    }
    this.#news();
  }
}
