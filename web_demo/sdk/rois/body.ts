/** A reserved body, as the application that holds it sees it. */

import type { ComponentClass } from "./component.ts";

/** Any class of components. */
export type AnyComponentClass = ComponentClass<object>;

/** Components of one engine that are reserved together. */
export interface Reservation {
  readonly engineId: string;
  /** The URNs of the types that may be missing. */
  readonly optional: ReadonlySet<string>;
  /** The references of the components that are bound, by the URNs of their types. */
  readonly bound: Map<string, string>;
  /** The application has the body. */
  complete: boolean;
  /** Why it is lost; null while it is not. */
  error: Error | null;
}

/** Components of one engine that this application holds until `release`, or until the body is lost. */
export class Body {
  readonly #reservation: Reservation;
  readonly #components: ReadonlyMap<string, object>;
  readonly #release: () => Promise<void>;

  /** @param components those that were bound, by the URN of their types */
  constructor(
    reservation: Reservation,
    components: ReadonlyMap<string, object>,
    release: () => Promise<void>,
  ) {
    this.#reservation = reservation;
    this.#components = components;
    this.#release = release;
  }

  /** The engine that the body is; `client.control.stopAll` takes it. */
  get engineId(): string {
    return this.#reservation.engineId;
  }

  /** Why the body is lost; null while it is held. */
  get error(): Error | null {
    return this.#reservation.error;
  }

  /**
   * Returns the component of a type. It stays what it was when the body is lost.
   *
   * @throws RangeError when the body was reserved without one
   */
  component<Component>(type: ComponentClass<Component>): Component {
    const component = this.#components.get(type.componentType);
    if (component === undefined)
      throw new RangeError(`${this.engineId} was reserved without ${type.componentType}`);
    return component as Component;
  }

  /** Returns the component of a type that is bound now; undefined where an optional one was taken, or is not there. */
  get<Component>(type: ComponentClass<Component>): Component | undefined {
    const isBound = this.#reservation.bound.has(type.componentType);
    return isBound ? (this.#components.get(type.componentType) as Component) : undefined;
  }

  /** Releases all components. Idempotent; never rejects. */
  release(): Promise<void> {
    return this.#release();
  }
}
