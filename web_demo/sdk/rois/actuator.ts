/** The standard's pattern for a component that acts: bind, execute, wait for `completed`, release. */

import type { CommandUnit, Completed, CompletedStatus } from "./types.ts";

/** The operations of a `RoISClient` that an actuator uses. */
export interface ActuatorClient {
  bind(componentRef: string): Promise<void>;
  release(componentRef: string): Promise<void>;
  execute(sequence: readonly CommandUnit[]): Promise<string[]>;
  completed(commandId: string): Promise<Completed>;
}

/**
 * Operates one component. It is reserved for this session from the start of a performance until the last one that
 * overlaps with it has ended; starting another one makes most components abort the first.
 */
export class Actuator {
  readonly componentRef: string;
  readonly #client: ActuatorClient;
  #performances = 0;
  #turn: Promise<unknown> = Promise.resolve();

  constructor(client: ActuatorClient, componentRef: string) {
    this.#client = client;
    this.componentRef = componentRef;
  }

  /** A performance has begun and has not ended. */
  get active(): boolean {
    return this.#performances > 0;
  }

  /**
   * Sets the parameters, starts the component and returns how it ended.
   *
   * @param onStarted is called when the engine has accepted the commands
   * @throws RoISError (OUT_OF_RESOURCES: another session holds the component) | RpcError | ConnectionLost
   */
  async perform(
    parameters: Readonly<Record<string, string>>,
    onStarted: () => void = () => undefined,
  ): Promise<CompletedStatus> {
    this.#performances += 1;
    try {
      const ids = await this.#inTurn(async () => {
        await this.#client.bind(this.componentRef);
        return this.#client.execute([
          {
            component_ref: this.componentRef,
            command_type: "set_parameter",
            arguments: Object.entries(parameters).map(([name, value]) => ({
              name,
              data_type_ref: "string",
              value,
            })),
          },
          { component_ref: this.componentRef, command_type: "start" },
        ]);
      });
      onStarted();
      const outcomes = await Promise.all(ids.map((id) => this.#client.completed(id)));
      return outcomes.find(({ status }) => status !== "OK")?.status ?? "OK";
    } finally {
      this.#performances -= 1;
      await this.#inTurn(async () => {
        if (!this.active) await this.#client.release(this.componentRef);
      }).catch(() => undefined);
    }
  }

  /** Ends what this session has started; its performance then ends with ABORT. */
  async stop(): Promise<void> {
    const [id] = await this.#client.execute([{ component_ref: this.componentRef, command_type: "stop" }]);
    if (id !== undefined) await this.#client.completed(id);
  }

  /** Requests may be answered out of order: a release must not overtake the bind that follows it. */
  #inTurn<T>(step: () => Promise<T>): Promise<T> {
    const result = this.#turn.then(step);
    this.#turn = result.catch(() => undefined);
    return result;
  }
}
