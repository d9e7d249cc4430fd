/** Walks of the avatar to a place or behind a person, and their outcome in words. */

import { CommandFailed, Follow, Navigation } from "../../sdk/index.ts";
import type { Client, Subscription } from "../../sdk/index.ts";
import { describeFailure } from "../model/outcome.ts";
import { plainReason, sentence } from "../model/plain_words.ts";
import { ahead } from "./geometry.ts";
import type { Place, Thing } from "./geometry.ts";

export interface Target {
  /** As RoIS has it: `x,y`, or the ref of a thing. */
  readonly text: string;
  /** As people read it. */
  readonly words: string;
  readonly place: Pick<Place, "x" | "y">;
}

export type WalkState = "idle" | "walking" | "done" | "stopped" | "failed" | "refused";

const BUSY = "another visitor is moving the body; try again in a moment";
/** Milliseconds for which it is said what became of a walk. */
const READABLE = 10_000;
/** Millimetres between the avatar and the person that it follows. */
const DISTANCE = 1000;

export class Walk {
  readonly #client: Client;
  readonly #onChange: () => void;
  #navigation: Navigation | null = null;
  #follow: Follow | null = null;
  #hearing: Promise<Subscription> | null = null;
  #targets: readonly Target[] = [];
  #followed: Thing | null = null;
  #state: WalkState = "idle";
  #words = "";
  #number = 0;
  #fading: ReturnType<typeof setTimeout> | undefined;
  #stopping = new AbortController();

  /** @param onChange is called when any of the properties has changed */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
  }

  /** Where it still has to go, in turn. */
  get targets(): readonly Target[] {
    return this.#targets;
  }

  get followed(): Thing | null {
    return this.#followed;
  }

  get state(): WalkState {
    return this.#state;
  }

  get words(): string {
    return this.#words;
  }

  get canFollow(): boolean {
    return this.#follow !== null;
  }

  /** @param navigation,follow refs of components; null where there are none */
  setComponents(navigation: string | null, follow: string | null): void {
    if (navigation !== (this.#navigation?.componentRef ?? null)) {
      void this.#hearing?.then((subscription) => subscription.cancel()).catch(() => undefined);
      this.#hearing = null;
      this.#navigation = navigation === null ? null : new Navigation(this.#client, navigation);
    }
    if (follow !== (this.#follow?.componentRef ?? null))
      this.#follow = follow === null ? null : new Follow(this.#client, follow);
  }

  /** @param further goes on from where it was going to */
  go(target: Target, further: boolean): void {
    const navigation = this.#navigation;
    if (!navigation) return;
    const targets = further ? [...this.#targets, target] : [target];
    const [first] = targets;
    const words =
      targets.length > 1 ? `Walking to ${targets.length} places` : `Walking to ${first?.words ?? ""}`;
    void this.#run(words, targets, null, async (signal) => {
      await this.#client.control.unlessStopped(navigation.componentRef, () => this.#hear(navigation));
      if (signal.aborted) throw new Stopped();
      await navigation.perform({ target_positions: targets.map(({ text }) => text) });
    });
  }

  follow(whom: Thing): void {
    const follow = this.#follow;
    if (!follow) return;
    void this.#run(`Following ${whom.name}`, [], whom, () =>
      follow.perform({ target_object_ref: whom.ref, distance: DISTANCE }),
    );
  }

  stop(): void {
    if (this.#state !== "walking") return;
    this.#stopping.abort();
    const component = this.#followed ? this.#follow : this.#navigation;
    if (component?.inUse) void component.stop().catch(() => undefined);
  }

  async #hear(navigation: Navigation): Promise<void> {
    this.#hearing ??= navigation.reachedTarget.subscribe(({ target }) => {
      this.#targets = ahead(this.#targets, target);
      this.#onChange();
    });
    // Without the event the marks of what was passed stay until the end.
    await this.#hearing.catch(() => (this.#hearing = null));
  }

  async #run(
    words: string,
    targets: readonly Target[],
    followed: Thing | null,
    perform: (signal: AbortSignal) => Promise<void>,
  ): Promise<void> {
    const number = ++this.#number;
    const began = Date.now();
    [this.#targets, this.#followed] = [targets, followed];
    this.#show("walking", words);
    this.#stopping = new AbortController();
    const [state, outcome] = await perform(this.#stopping.signal).then(
      () => ["done", `Arrived after ${((Date.now() - began) / 1000).toFixed(1)} s`] as const,
      (error: unknown) => failure(error),
    );
    // A walk that the next one has ended is of no concern any more.
    if (number !== this.#number) return;
    [this.#targets, this.#followed] = [[], null];
    this.#show(state, outcome);
  }

  #show(state: WalkState, words: string): void {
    clearTimeout(this.#fading);
    if (state !== "walking" && state !== "idle")
      this.#fading = setTimeout(() => this.#show("idle", ""), READABLE);
    this.#state = state;
    this.#words = words;
    this.#onChange();
  }
}

/** Stopped before the walk began. */
class Stopped extends Error {}

function failure(error: unknown): readonly [WalkState, string] {
  if (error instanceof Stopped) return ["stopped", "Stopped"];
  if (!(error instanceof CommandFailed)) {
    const { state, text } = describeFailure(error, BUSY);
    return [state, sentence(text)];
  }
  const why = sentence(plainReason(error.reason));
  if (error.status === "ABORT") return ["stopped", why || "Stopped"];
  if (error.status === "TIMEOUT") return ["failed", "It took too long"];
  return ["failed", why || "It could not get there"];
}
