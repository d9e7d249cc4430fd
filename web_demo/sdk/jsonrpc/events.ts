/** Typed events: a listener that throws is reported and harms no other listener. */

type Listener<T> = (value: T) => void;

/** Calls a listener and reports what it throws, at once or later, on the console. */
export function notifyListener<T>(name: string, listener: Listener<T>, value: T): void {
  const failed = (error: unknown): void => console.error(`openrois: a listener of "${name}" failed`, error);
  try {
    const ended: unknown = listener(value);
    // An async function is a listener, too.
    if (ended instanceof Promise) ended.catch(failed);
  } catch (error) {
    failed(error);
  }
}

/** Event emitter: calls listeners in the order in which they were added. */
export class Emitter<Events extends object> {
  readonly #listeners = new Map<keyof Events, Set<Listener<never>>>();

  /** Adds a listener and returns the function that removes it. */
  on<Name extends keyof Events>(name: Name, listener: Listener<Events[Name]>): () => void {
    const listeners = this.#listeners.get(name) ?? new Set();
    this.#listeners.set(name, listeners);
    listeners.add(listener as Listener<never>);
    return () => void listeners.delete(listener as Listener<never>);
  }

  emit<Name extends keyof Events>(name: Name, value: Events[Name]): void {
    // A copy, since a listener may remove itself while it runs.
    for (const listener of [...(this.#listeners.get(name) ?? [])]) {
      notifyListener(String(name), listener as Listener<Events[Name]>, value);
    }
  }
}
