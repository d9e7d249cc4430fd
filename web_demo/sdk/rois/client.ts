/** The RoIS 2.0 client: the operations of the System, Command, Query and Event interfaces over one gateway. */

import { Bindings } from "./bindings.ts";
import type { AnyComponentClass, Body } from "./body.ts";
import type { BodyInfo } from "./body_directory.ts";
import type { Renewal } from "./claims.ts";
import { Completions } from "./completions.ts";
import { Control } from "./control.ts";
import type { ComponentClass } from "./component.ts";
import { and, where } from "./conditions.ts";
import { componentUrn } from "./discovery.ts";
import { DIRECTORY, EngineDirectory } from "./engine_directory.ts";
import { RoISError } from "./errors.ts";
import type {
  CommandUnit,
  ComponentEntry,
  ConcurrentCommands,
  DirectoryChangedNotification,
  EngineEntry,
  HRIComponentProfile,
  HRIEngineProfile,
  Parameter,
  Result,
} from "./generated/types.ts";
import { Link } from "./link.ts";
import type { Call, ClientOptions, Ended, RoISEvent } from "./link.ts";
import type { ProfileChange } from "./profile_change.ts";
import { Bodies } from "./reserving.ts";
import type { BodyLoss, BodyOptions } from "./reserving.ts";
import { Resumption } from "./resumption.ts";
import { Restoration } from "./restoration.ts";
import { Stops } from "./stops.ts";
import { Subscriptions, iterate } from "./subscriptions.ts";
import type { Subscription } from "./subscriptions.ts";

/** The tree of engines, and the profile of each component by its reference. */
export interface Profile {
  readonly profile: HRIEngineProfile | null;
  readonly component_profiles: { readonly [componentRef: string]: HRIComponentProfile };
}

/** One command to be sent; a missing `command_id` is minted. `delay_time` is in milliseconds. */
export type Command = Omit<CommandUnit, "command_id"> & { readonly command_id?: string };

/** Commands that run at the same time; the next item of the sequence waits for all of them. */
export type Concurrent = Omit<ConcurrentCommands, "command_list"> & {
  readonly command_list: readonly Command[];
};

/** One item of a command sequence; items run one after another. */
export type Step = Command | Concurrent;

/**
 * A RoIS application's end of one gateway. It connects again by itself, and what it has bound and subscribed comes
 * back with it; what does not is reported by `on("lost")`.
 *
 * Every operation throws `RoISError` when its return code is not OK, `RpcError` when the gateway does not know it or
 * its params, `InvalidMessage` when the answer is none, and `ConnectionLost` or `RequestTimeout` when there is none.
 */
export class Client extends Link {
  readonly #completions = new Completions();
  readonly #subscriptions = new Subscriptions();
  readonly #stops = new Stops((isStopped) => this.emitter.emit("stopped", isStopped));
  readonly #bindings = new Bindings(this.#stops);
  readonly #restoration: Restoration;
  readonly #resumption: Resumption;
  readonly #directory = new EngineDirectory(this.call);
  readonly #bodies: Bodies;
  /** Asks for components that others hold, hands them over, and stops everything. */
  readonly control: Control;

  /**
   * @param url the gateway, `ws://`, `wss://` or what it prints, `http://`; read relative to the page, which is what
   *   it is without it
   * @throws TypeError when `url` is no address, there is no WebSocket here and no `webSocket` is given, or that is a class
   */
  constructor(url?: string | URL, options?: ClientOptions) {
    super(url, options);
    const renewal: Renewal = {
      lost: (claim) => this.onceConnected(() => this.emitter.emit("lost", claim)),
      lent: (claim) => this.emitter.emit("lent", claim),
      restored: (claim) => this.onceConnected(() => this.emitter.emit("restored", claim)),
    };
    this.#restoration = new Restoration(this.#bindings, this.#subscriptions, renewal, options?.backoff);
    this.control = new Control(this, this.#bindings, this.#stops);
    this.control.on("openrois.lease.changed", (lease) => {
      if (this.#bindings.holderChanged(lease, renewal)) this.#restoration.changed(this.call, null);
    });
    this.#resumption = new Resumption(this.#completions);
    const lost = (loss: BodyLoss): void => this.emitter.emit("body_lost", loss);
    this.#bodies = new Bodies(this, this.#directory, this.#bindings, lost, options?.backoff);
    this.on("completed", (completed) => this.#completions.completed(completed));
    this.on("event", (event) => this.#subscriptions.deliver(event));
  }

  /** Returns which engines there are, and what the components that match understand. */
  async getProfile(condition = ""): Promise<Profile> {
    const { profile = null, component_profiles = {} } = await this.call("rois.system.get_profile", {
      condition,
    });
    return { profile, component_profiles };
  }

  /**
   * Returns the engines behind a gateway that speaks `openrois.directory` in short, by their ids. They are listed once,
   * in pages; from then on only those are read that have changed.
   *
   * @throws RpcError where the gateway does not speak it; `getProfile` knows them then
   */
  engines(): Promise<ReadonlyMap<string, EngineEntry>> {
    return this.#directory.read();
  }

  /**
   * Returns the profiles of components that `engines` has listed, by their `profile_version`. Components with equal
   * profiles have the same: each version is loaded once, and kept. Those of components that have gone, or have changed
   * meanwhile, are absent.
   *
   * @throws RpcError where the gateway does not speak `openrois.directory`
   */
  profiles(components: Iterable<ComponentEntry>): Promise<ReadonlyMap<string, HRIComponentProfile>> {
    return this.#directory.profiles(components);
  }

  /** Returns what is known of a fault; its id came with `on("fault")`. */
  async getErrorDetail(errorId: string): Promise<readonly Result[]> {
    return (await this.call("rois.system.get_error_detail", { error_id: errorId })).results ?? [];
  }

  /** Returns the references of the components that match. */
  async search(condition = ""): Promise<readonly string[]> {
    return (await this.call("rois.command.search", { condition })).component_ref_list ?? [];
  }

  /**
   * Finds a component of a type: `await client.find(Navigation)`.
   *
   * @param condition what else must hold, such as `like("component_ref", "robot/%")`
   * @throws RoISError (UNSUPPORTED: there is none; BAD_PARAMETER: there are several, and it says which)
   */
  async find<Component>(type: ComponentClass<Component>, condition = ""): Promise<Component> {
    const refs = await this.#refsOf(type, condition);
    const [componentRef] = refs;
    if (componentRef === undefined) {
      const reason = `there is no such component${condition && ` where ${condition}`}`;
      throw new RoISError("UNSUPPORTED", `find ${type.componentType}`, "", reason);
    }
    if (refs.length > 1) {
      const choice = `take one that is free by \`client.body\`, or name one by a condition`;
      const reason = `there are ${refs.length}: ${refs.join(", ")}; ${choice}`;
      throw new RoISError("BAD_PARAMETER", `find ${type.componentType}`, "", reason);
    }
    return new type(this, componentRef);
  }

  /** Returns the bodies behind the gateway: what each can do, and whether it is free. */
  bodies(): Promise<BodyInfo[]> {
    return this.#bodies.all();
  }

  /**
   * Reserves a body, until it is released: `await client.body([Navigation, SpeechSynthesis])`. All components are bound of
   * one body, or none. Of several bodies the first that is free is taken, those with more of the optional types first; of
   * several components of a type in it the first by reference. A body whose required component is lost is given back, and
   * `on("body_lost")` tells.
   *
   * @throws RoISError (OUT_OF_RESOURCES: all that have the components are taken, and it says which refused; UNSUPPORTED:
   *   there is no such body, and it says which there are) | RangeError: no type is named, or one twice
   */
  body(types: readonly AnyComponentClass[], options: BodyOptions = {}): Promise<Body> {
    return this.#bodies.reserve(types, options);
  }

  /** Finds all components of a type. */
  async findAll<Component>(type: ComponentClass<Component>, condition = ""): Promise<Component[]> {
    const refs = await this.#refsOf(type, condition);
    return refs.map((componentRef) => new type(this, componentRef));
  }

  async #refsOf(type: ComponentClass<unknown>, condition: string): Promise<readonly string[]> {
    let refs = await this.search(and(where({ component_type: type.componentType }), condition));
    if (refs.length === 0 && !this.extensions?.includes(DIRECTORY)) {
      // Some gateways compare the code of the identifier alone with the URN.
      const profiles = Object.entries((await this.getProfile(condition)).component_profiles);
      refs = profiles.flatMap(([ref, profile]) =>
        componentUrn(profile) === type.componentType ? [ref] : [],
      );
    }
    return refs;
  }

  /**
   * Reserves a component for this application until it is released, also over a lost connection. Idempotent.
   *
   * @throws RoISError (OUT_OF_RESOURCES: another application has it)
   */
  async bind(componentRef: string): Promise<void> {
    await this.#bindings.bind(this.call, componentRef);
  }

  /** Reserves one component that matches and is free, and returns its reference. */
  async bindAny(condition = ""): Promise<string> {
    return this.#bindings.bindAny(this.call, condition);
  }

  /** Gives a component back, once no work of `bound` needs it any more. Idempotent. */
  async release(componentRef: string): Promise<void> {
    if (!this.#bindings.delete(componentRef)) return;
    await this.call("rois.command.release", { component_ref: componentRef });
  }

  /**
   * Does some work while a component is bound. Where works overlap the last one releases it; a component bound by `bind`
   * stays so. What is stopped meanwhile does not begin: by this client, with a command `stop` or
   * `control.stopAll`, or by a person, where the gateway notifies this client of that.
   *
   * @throws RoISError (OUT_OF_RESOURCES: another application has it) | CommandFailed (ABORT: it was stopped before it
   *   began) | what the work throws
   */
  bound<T>(componentRef: string, work: () => Promise<T>): Promise<T> {
    return this.#bindings.during(this.call, componentRef, work);
  }

  /** Returns the parameters that have a value. */
  async getParameter(componentRef: string): Promise<readonly Parameter[]> {
    return (await this.call("rois.command.get_parameter", { component_ref: componentRef })).parameters ?? [];
  }

  /** Changes parameters, all in one; returns the id of the command, which ends in `completed`. */
  async setParameter(componentRef: string, parameters: readonly Parameter[]): Promise<string> {
    const params = { component_ref: componentRef, parameters };
    const { command_id = "" } = await this.call("rois.command.set_parameter", params);
    this.#completions.expect(command_id);
    return command_id;
  }

  /**
   * Starts a sequence of commands and returns their ids, in order, once the engine has accepted all of them. Each
   * ends later in `completed`; a refusal starts nothing.
   */
  async execute(sequence: readonly Step[]): Promise<string[]> {
    const ids: string[] = [];
    const identified = (command: Command): CommandUnit => {
      const unit = { ...command, command_id: command.command_id ?? newCommandId() };
      if (unit.command_type === "stop") this.#stops.stopComponent(unit.component_ref);
      ids.push(unit.command_id);
      return unit;
    };
    const list = sequence.map((step) =>
      "command_list" in step
        ? { ...step, command_list: step.command_list.map(identified) }
        : identified(step),
    );
    for (const id of ids) this.#completions.expect(id);
    try {
      await this.call("rois.command.execute", { command_unit_list: list });
    } catch (error) {
      for (const id of ids) this.#completions.discardCommand(id);
      throw error;
    }
    return ids;
  }

  /**
   * Waits until a command has ended, also if it ended before.
   *
   * @param within milliseconds to wait at most; without it, as long as the connection lasts
   * @throws ConnectionLost when the connection ended first: how the command ends is not known | RequestTimeout
   */
  completed(commandId: string, within?: number): Promise<Ended> {
    return this.#completions.wait(commandId, within);
  }

  /** Returns what a command that ended OK has given. */
  async getCommandResult(commandId: string): Promise<readonly Result[]> {
    return (await this.call("rois.command.get_command_result", { command_id: commandId })).results ?? [];
  }

  /** Asks the one component that answers `queryType` and meets the condition. */
  async query(queryType: string, condition = ""): Promise<readonly Result[]> {
    return (await this.call("rois.query.query", { query_type: queryType, condition })).results ?? [];
  }

  /** Subscribes to an event of the one component that meets the condition, also after a reconnect. */
  subscribe(
    eventType: string,
    condition: string,
    listener: (event: RoISEvent) => void,
    onEnd?: () => void,
  ): Promise<Subscription> {
    return this.#subscriptions.add(this.call, eventType, condition, listener, onEnd);
  }

  /**
   * The same to be iterated over: `for await (const event of client.events("person_detected", condition))`. It ends
   * with the loop, or with the client. A reader that is too slow misses the oldest of more than 256 events.
   */
  events(eventType: string, condition: string): AsyncIterable<RoISEvent> {
    return iterate((listener, onEnd) => this.subscribe(eventType, condition, listener, onEnd));
  }

  /** Returns the results of an event, while the gateway remembers it (`expire`). */
  async getEventDetail(eventId: string): Promise<readonly Result[]> {
    return (await this.call("rois.event.get_event_detail", { event_id: eventId })).results ?? [];
  }

  protected override async sessionBegan(call: Call): Promise<void> {
    this.#directory.reset();
    this.#bindings.resumed(call, await this.#resumption.begin(call, this.extensions));
    await this.#restoration.begin(call);
  }

  protected override sessionEnded(closed: boolean, code?: number): void {
    this.#resumption.sessionEnded(closed, code);
    this.#restoration.stop();
    if (!closed) return;
    this.#subscriptions.endAll();
    this.#bindings.clear();
  }

  protected override profileChanged(change: ProfileChange, notice?: DirectoryChangedNotification): void {
    if (notice) this.#directory.noteChanges(notice);
    else this.#directory.reset();
    this.#restoration.changed(this.call, change);
  }
}

/** `crypto.randomUUID` exists on secure origins only; a page over plain HTTP on a LAN is none. */
function newCommandId(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(12));
  return `command-${Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}
