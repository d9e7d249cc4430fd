/** What the cards of one component share. */

import type { Client } from "../../sdk/index.ts";
import type { Drafts } from "./value_form.ts";

export interface ComponentBench {
  readonly client: Client;
  readonly ref: string;
  readonly drafts: Drafts;
  /** Binds the component. @throws what `Client.bind` throws */
  bind(): Promise<void>;
  /** Is called after an operation on the component, which may have changed its status. */
  onWork(): void;
  /** Is called for an event, and when a subscription begins or ends. */
  onEvent(): void;
}

/** A part of the panel that stands for one message, or for the parameters. */
export interface Card {
  readonly element: HTMLElement;
  /** The component has come back, or the panel is shown again: what it remembers may be old. */
  refresh?(): void;
  /** The message is gone from the profile. */
  close?(): void;
}
