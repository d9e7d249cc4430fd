/** What has changed behind a gateway. */

import { engineOf } from "./discovery.ts";

/** Engines came, went, or are others now. */
export interface ProfileChange {
  /** Which engines; empty where the gateway does not say, or there are too many: any may have changed. */
  readonly engineIds: ReadonlySet<string>;
}

/** Whether a change may concern an engine, a component, or what else has a name that begins with an engine's id. */
export function mayConcern({ engineIds }: ProfileChange, id: string): boolean {
  return engineIds.size === 0 || engineIds.has(engineOf(id));
}
