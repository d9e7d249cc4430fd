/** Events to be iterated over instead of listened to. */

import type { RoISEvent } from "./link.ts";
import type { Subscription } from "./subscriptions.ts";

/** How many events may wait for their reader; the oldest makes room. */
const BUFFER = 256;

type Subscribe = (listener: (event: RoISEvent) => void, onEnd: () => void) => Promise<Subscription>;

/** Subscribes when the iteration begins; its end, or that of the client, ends the subscription. */
export async function* iterate(subscribe: Subscribe): AsyncGenerator<RoISEvent, void, void> {
  const waiting: RoISEvent[] = [];
  let ended = false;
  let wake = (): void => undefined;
  const subscription = await subscribe(
    (event) => {
      if (waiting.length === BUFFER) waiting.shift();
      waiting.push(event);
      wake();
    },
    () => {
      ended = true;
      wake();
    },
  );
  try {
    for (;;) {
      const event = waiting.shift();
      if (event !== undefined) yield event;
      else if (ended) return;
      else await new Promise<void>((resolve) => (wake = resolve));
    }
  } finally {
    await subscription.cancel();
  }
}
