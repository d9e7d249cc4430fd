/** Stopping what may not have begun yet: a stop that overtakes its start stops nothing. */

const AGAIN = 250;
const TRIES = 20;

/** What of a component is needed. */
export interface Stoppable {
  readonly inUse: boolean;
  stop(): Promise<void>;
}

/**
 * Stops a component, and again until what was to be stopped has ended.
 *
 * @param runs whether that still goes on
 * @returns resolves when it was stopped for the first time; how that ends is all the same
 */
export async function stopUntilEnded(component: Stoppable, runs: () => boolean): Promise<void> {
  const stop = (): Promise<void> =>
    component.inUse ? component.stop().catch(() => undefined) : Promise.resolve();
  await stop();
  void (async () => {
    for (let tries = 1; tries < TRIES && runs(); tries += 1) {
      await new Promise((resolve) => setTimeout(resolve, AGAIN));
      if (runs()) await stop();
    }
  })();
}
