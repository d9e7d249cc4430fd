/** What the cards of one component share. */

import type { Client } from "../../sdk/index.ts";
import type { Drafts } from "./value_form.ts";

export interface ComponentBench {
  readonly client: Client;
  readonly ref: string;
  readonly drafts: Drafts;
  /** Binds the component. @throws what `Client.bind` throws */
  bind(): Promise<void>;
  /** The component was made to do something: its status may be another now. */
  worked(): void;
  /** An event came in, or it is listened to one event more or less. */
  heard(): void;
}

/** A part of the panel that stands for one message, or for the parameters. */
export interface Card {
  readonly element: HTMLElement;
  /** The component has come back, or the panel is shown again: what it remembers may be old. */
  refresh?(): void;
  /** The message is gone from the profile. */
  close?(): void;
}
