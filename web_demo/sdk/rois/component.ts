/** The run time of typed components: what `Navigation` and its like are made of. */

import { notifyListener } from "../jsonrpc/events.ts";
import type { Client } from "./client.ts";
import { and, onlyComponent } from "./conditions.ts";
import { CommandFailed } from "./errors.ts";
import type { Result } from "./generated/types.ts";
import type { RoISEvent } from "./link.ts";
import { decode, encode } from "./payload.ts";
import type { Types } from "./payload.ts";
import type { Subscription } from "./subscriptions.ts";

export { encode } from "./payload.ts";
export type { Types } from "./payload.ts";

/** The class of a kind of component, as `Client.find` takes it. */
export interface ComponentClass<Component> {
  /** The URN of the type. */
  readonly componentType: string;
  new (client: Client, componentRef: string): Component;
}

/** What an application may set of parameters: not those that the component alone knows. */
export type Settable<Parameters, ReadOnly extends keyof Parameters> = Partial<Parameters> & {
  readonly [Name in ReadOnly]?: never;
};

/**
 * One component of an engine, with its commands, queries and events as methods. Subclasses are generated for the basic
 * components; one's own kind of component is written in the same way:
 *
 * ```ts
 * class Lamp extends RoISCommon<LampParameters> {
 *   static readonly componentType = "urn:x-rois:def:component:Example::Lamp";
 *   protected override readonly parameterTypes = { brightness: "int" };
 *   readonly switched = this.event<{ on: boolean }>("switched", { on: "bool" });
 * }
 * ```
 *
 * Commands resolve when they have ended, and throw `CommandFailed` when they have not ended well. All operations throw
 * what those of the `Client` throw, and `ValueError` when a value does not fit its type.
 */
export class ComponentProxy<Parameters extends object = object, ReadOnly extends keyof Parameters = never> {
  /** Where the component is: `<engine id>/<name>`. */
  readonly componentRef: string;
  /** The `data_type_ref` of each parameter. */
  protected readonly parameterTypes: Types<Parameters> = {} as Types<Parameters>;
  readonly #client: Client;
  #works = 0;

  constructor(client: Client, componentRef: string) {
    this.#client = client;
    this.componentRef = componentRef;
  }

  /**
   * Reserves the component for this application; an actuation takes commands from its holder alone. Idempotent.
   *
   * @throws RoISError (OUT_OF_RESOURCES: another application has it)
   */
  bind(): Promise<void> {
    return this.#client.bind(this.componentRef);
  }

  /** Gives the component back. Idempotent. */
  release(): Promise<void> {
    return this.#client.release(this.componentRef);
  }

  /** Does some work while the component is bound. Where works overlap, the last one releases it. */
  async bound<T>(work: () => Promise<T>): Promise<T> {
    this.#works += 1;
    try {
      return await this.#client.bound(this.componentRef, work);
    } finally {
      this.#works -= 1;
    }
  }

  /** Whether a work of `bound` or `perform` is under way. */
  get inUse(): boolean {
    return this.#works > 0;
  }

  /** Returns the parameters that have a value. */
  async getParameter(): Promise<Partial<Parameters>> {
    return decode(this.parameterTypes, await this.#client.getParameter(this.componentRef), true);
  }

  /** Changes parameters, all in one, and waits until that is done. Those that are read only are the component's. */
  async setParameter(values: Settable<Parameters, ReadOnly>): Promise<void> {
    const parameters = encode(this.parameterTypes, values);
    await this.#awaitEnd("set_parameter", await this.#client.setParameter(this.componentRef, parameters));
  }

  /**
   * The standard's pattern for a component that acts: binds it, sets parameters, starts it, waits until it has ended,
   * and releases it. Starting it once more meanwhile makes most components abort what they do; `stop` ends it, also
   * while it has not begun.
   *
   * @param onStart is called when the engine has accepted it
   * @throws CommandFailed (ABORT: it was stopped) | RoISError (OUT_OF_RESOURCES: another application has it)
   */
  async perform(
    values: Settable<Parameters, ReadOnly>,
    onStart: () => void = () => undefined,
  ): Promise<void> {
    const parameters = encode(this.parameterTypes, values);
    const work = async (): Promise<void> => {
      const { componentRef: component_ref } = this;
      const ids = await this.#client.execute([
        { component_ref, command_type: "set_parameter", arguments: parameters },
        { component_ref, command_type: "start" },
      ]);
      onStart();
      const [set = "", start = ""] = ids;
      await this.#awaitEnd("set_parameter", set);
      await this.#awaitEnd("start", start);
    };
    await this.bound(work);
  }

  /** Runs a command to its end. */
  protected async execute(commandType: string, values?: readonly Result[]): Promise<void> {
    await this.#run(commandType, values);
  }

  /** Runs a command to its end and returns what it gave. */
  protected async obtain<Payload>(
    commandType: string,
    types: Types<Payload>,
    values?: readonly Result[],
  ): Promise<Payload> {
    const commandId = await this.#run(commandType, values);
    return decode(types, await this.#client.getCommandResult(commandId));
  }

  /** Queries the component; `condition` says what else must hold. */
  protected async query<Payload>(queryType: string, types: Types<Payload>, condition = ""): Promise<Payload> {
    const results = await this.#client.query(queryType, and(onlyComponent(this.componentRef), condition));
    return decode(types, results);
  }

  /** Returns an event of the component. */
  protected event<Payload>(eventType: string, types: Types<Payload>): ComponentEvent<Payload> {
    return new ComponentEvent(this.#client, eventType, this.componentRef, types);
  }

  async #run(commandType: string, values: readonly Result[] = []): Promise<string> {
    const command = { component_ref: this.componentRef, command_type: commandType };
    const [commandId = ""] = await this.#client.execute([
      values.length > 0 ? { ...command, arguments: values } : command,
    ]);
    await this.#awaitEnd(commandType, commandId);
    return commandId;
  }

  async #awaitEnd(commandType: string, commandId: string): Promise<void> {
    const { status, reason } = await this.#client.completed(commandId);
    if (status !== "OK")
      throw new CommandFailed(`${commandType} of ${this.componentRef}`, commandId, status, reason);
  }
}

/**
 * An event of one component, to be listened to or iterated over:
 *
 * ```ts
 * await navigation.reachedTarget.subscribe(({ target }) => console.log(target));
 * for await (const { target, is_final_target } of navigation.reachedTarget) if (is_final_target) break;
 * ```
 */
export class ComponentEvent<Payload> implements AsyncIterable<Payload> {
  /** Its name on the wire. */
  readonly eventType: string;
  readonly #client: Client;
  readonly #componentRef: string;
  readonly #types: Types<Payload>;

  constructor(client: Client, eventType: string, componentRef: string, types: Types<Payload>) {
    this.#client = client;
    this.eventType = eventType;
    this.#componentRef = componentRef;
    this.#types = types;
  }

  /** Subscribes to the event, also after a reconnect. */
  subscribe(listener: (payload: Payload, event: RoISEvent) => void): Promise<Subscription> {
    let turn: Promise<unknown> = Promise.resolve();
    return this.#client.subscribe(this.eventType, onlyComponent(this.#componentRef), (event) => {
      turn = turn
        .then(() => this.#read(event))
        .then((payload) => {
          if (payload !== undefined)
            notifyListener(this.eventType, (value) => listener(value, event), payload);
        });
    });
  }

  /** Iterates over the event from now on; a reader that is too slow misses the oldest of more than 256. */
  async *[Symbol.asyncIterator](): AsyncGenerator<Payload, void, void> {
    for await (const event of this.#client.events(this.eventType, onlyComponent(this.#componentRef))) {
      const payload = await this.#read(event);
      if (payload !== undefined) yield payload;
    }
  }

  /** Reads the results, or asks for them where the engine sent none. Unreadable ones are reported and skipped. */
  async #read(event: RoISEvent): Promise<Payload | undefined> {
    const { event_id: eventId, results } = event;
    try {
      const complete = results.length > 0 || Object.keys(this.#types).length === 0;
      return decode(this.#types, complete ? results : await this.#client.getEventDetail(eventId));
    } catch (error) {
      this.#client.passedOver(`${this.eventType} of ${this.#componentRef}: ${String(error)}`);
      return undefined;
    }
  }
}
