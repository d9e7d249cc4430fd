/** Teleoperation of an avatar: binds its component, collects the operator's input, and sends it. */

import { Emitter } from "../jsonrpc/events.ts";
import type { Client } from "../rois/client.ts";
import { onlyComponent } from "../rois/conditions.ts";
import { engineOf } from "../rois/discovery.ts";
import { resultValue } from "../rois/payload.ts";
import type { InputChannels } from "./channels.ts";
import { Collector } from "./collector.ts";
import type { CollectorOptions } from "./collector.ts";
import { Held } from "./held.ts";
import { message } from "./messages.ts";
import type { Change, EngineMessage, Why } from "./messages.ts";

/** Milliseconds between two readings of gamepad and movements: about one frame of a screen. */
const PACE = 16;
/** Milliseconds after which a state is sent again while something is held; the engine stops without one for 400. */
const REPEAT = 80;
/** How often, and how many milliseconds apart, the engine is asked whether it has begun. */
const ASKED = 20;
const ASK_AGAIN = 50;

/** Source of the data channels: a `MediaReceiver` made with `input: true`. */
export interface InputMedia {
  inputs(engineId: string): InputChannels[];
}

export interface TeleoperationEvents {
  /** Input is refused, or the figure was stopped; the value is the reason, a sentence. */
  refused: string;
  stopped: string;
  /** The figure's speed changed with the network delay; the value is a sentence. */
  paced: string;
  /** Operation ended without `stop`; the value is the reason. */
  ended: string;
}

export class Teleoperation {
  readonly componentRef: string;
  readonly #client: Client;
  readonly #media: InputMedia;
  readonly #events = new Emitter<TeleoperationEvents>();
  readonly #held = new Held();
  #collector: Collector | null = null;
  #endStops: () => void = () => undefined;
  #timer: ReturnType<typeof setInterval> | undefined;
  #command: string | null = null;
  #moved = false;
  #sentAt = -Infinity;

  constructor(client: Client, media: InputMedia, componentRef: string) {
    this.#client = client;
    this.#media = media;
    this.componentRef = componentRef;
  }

  /** Whether this application operates. */
  get operating(): boolean {
    return this.#command !== null;
  }

  /** Whether input can be sent now: a stream of the avatar is there, and its channels are open. */
  get linked(): boolean {
    return this.#media.inputs(engineOf(this.componentRef)).length > 0;
  }

  on<Name extends keyof TeleoperationEvents>(
    name: Name,
    listener: (value: TeleoperationEvents[Name]) => void,
  ): () => void {
    return this.#events.on(name, listener);
  }

  /**
   * Binds the component and begins to operate.
   *
   * @throws RoISError (OUT_OF_RESOURCES: another application has it) | CommandFailed (ABORT: it was stopped meanwhile)
   */
  async start(): Promise<void> {
    if (this.#command !== null) return;
    await this.#client.control.unlessStopped(
      this.componentRef,
      () => this.#client.bind(this.componentRef),
      () => this.#client.release(this.componentRef),
    );
    const [command = ""] = await this.#client.execute([
      { component_ref: this.componentRef, command_type: "start" },
    ]);
    this.#command = command;
    void this.#client.completed(command).then(
      ({ status, reason }) => this.#operationEnded(command, reason || status),
      () => this.#operationEnded(command, "the connection to the gateway was lost"),
    );
    // Input takes a shorter way than the command: it must not arrive before the component operates.
    for (let asked = 0; asked < ASKED && this.#command === command; asked += 1) {
      const results = await this.#client.query("operation", onlyComponent(this.componentRef));
      if (resultValue(results, "operated") === "true") break;
      await new Promise((resolve) => setTimeout(resolve, ASK_AGAIN));
    }
  }

  /** Releases everything held, stops operating, and releases the component. */
  async stop(): Promise<void> {
    if (this.#command === null) return;
    this.#release("bye");
    this.#command = null;
    await this.#client.execute([{ component_ref: this.componentRef, command_type: "stop" }]);
    await this.#client.release(this.componentRef);
  }

  /**
   * Sends the operator's input at an element (the video), from now on and while this application operates. What is held
   * while the body is stopped counts again once it is pressed anew.
   *
   * @returns detaches from the element
   */
  attach(element: HTMLElement, options: CollectorOptions = {}): () => void {
    this.detach();
    const events = {
      onChange: (change: Change) => this.#change(change),
      onMove: () => (this.#moved = true),
      onRelease: (why: Why) => this.#release(why),
    };
    const collector = new Collector(element, this.#held, events, options);
    this.#collector = collector;
    this.#endStops = this.#client.on("stopped", (isStopped) => {
      if (isStopped(this.componentRef)) this.#halt();
    });
    this.#timer = setInterval(() => this.#sendDue(), PACE);
    return () => {
      if (this.#collector === collector) this.detach();
    };
  }

  /** A stick on the screen was moved, while `attach` lasts: x from -1 (left) to 1, y from -1 (up) to 1; 0, 0 lets go. */
  stick(x: number, y: number): void {
    if (!this.#collector) return;
    this.#held.stick(x, y);
    this.#moved = true;
    this.#sendDue();
  }

  detach(): void {
    if (!this.#collector) return;
    this.#release("bye");
    clearInterval(this.#timer);
    this.#endStops();
    this.#collector.detach();
    this.#collector = null;
  }

  get #channels(): InputChannels | null {
    if (this.#command === null) return null;
    const channels = this.#media.inputs(engineOf(this.componentRef))[0] ?? null;
    if (channels) channels.onMessage = ({ event, reason }: EngineMessage) => this.#events.emit(event, reason);
    return channels;
  }

  #sendDue(): void {
    this.#collector?.poll();
    const now = performance.now();
    const due = this.#held.active && now - this.#sentAt >= REPEAT;
    if (!this.#moved && !due) return;
    if (this.#channels?.sendState(message(this.#held.state)) !== true) return;
    this.#moved = false;
    this.#sentAt = now;
  }

  #change(change: Change): void {
    this.#moved = true;
    this.#channels?.sendChange(message(change));
    this.#sendDue();
  }

  #release(why: Why): void {
    this.#held.clear();
    this.#sendRelease(why);
  }

  /** Ends what is held before the gateway's STOP can: this is the shorter way. */
  #halt(): void {
    this.#held.halt();
    this.#sendRelease("blur");
  }

  #sendRelease(why: Why): void {
    this.#moved = false;
    const channels = this.#channels;
    channels?.sendChange(message({ event: "release", why }));
    channels?.sendState(message(this.#held.state));
  }

  #operationEnded(command: string, reason: string): void {
    if (this.#command !== command) return;
    this.#command = null;
    this.#held.clear();
    // The application has to start again: the client must not bind the component again by itself.
    void this.#client.release(this.componentRef).catch(() => undefined);
    this.#events.emit("ended", reason);
  }
}
