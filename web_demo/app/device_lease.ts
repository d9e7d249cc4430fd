/** Control of the avatar for as long as a microphone or camera is on: with tokens, only who has control may send. */

import type { Client } from "../sdk/index.ts";
import { describeFailure } from "./outcome.ts";

const BUSY = "somebody else has control: ask for it, and turn it on again";

/** Ends what was begun. */
export type GiveBack = () => void;

export class DeviceLease {
  readonly #client: Client;
  readonly #isNeeded: () => boolean;
  #componentRef: string | null = null;

  /**
   * @param isNeeded whether the gateway asks who sends: one without authentication does not
   * @param onLost is told who has control now, in a sentence
   */
  constructor(client: Client, isNeeded: () => boolean, onLost: (sentence: string) => void) {
    this.#client = client;
    this.#isNeeded = isNeeded;
    client.control.on("openrois.lease.changed", ({ component_ref, state, holder }) => {
      if (component_ref === this.#componentRef && state === "HELD") onLost(`${holder} has control now.`);
    });
    client.on("lost", (claim) => {
      if (claim.kind === "binding" && claim.componentRef === this.#componentRef)
        onLost("Control was lost with the connection. Turn it on again.");
    });
  }

  /** @param componentRef whoever holds this component has control; null while there is none, or it is away */
  setComponent(componentRef: string | null): void {
    this.#componentRef = componentRef ?? this.#componentRef;
  }

  /**
   * Takes control, also if it is had already; where several have taken it the last one gives it back.
   *
   * @throws Error with a sentence for a person
   */
  take(): Promise<GiveBack> {
    const componentRef = this.#componentRef;
    if (componentRef === null || !this.#isNeeded()) return Promise.resolve(() => undefined);
    return new Promise((resolve, reject) => {
      const work = (): Promise<void> => new Promise((end) => resolve(end));
      this.#client.bound(componentRef, work).catch((error: unknown) => reject(sentence(error)));
    });
  }
}

function sentence(error: unknown): Error {
  const { text } = describeFailure(error, BUSY);
  return new Error(`${text.charAt(0).toUpperCase()}${text.slice(1)}.`);
}
