/** STOP on this side of the wire: what was stopped before it began does not begin afterwards. */

import { CommandFailed } from "./errors.ts";

/** Tells of a component whether it is stopped. */
export type IsStopped = (componentRef: string) => boolean;

/** A work that was asked for, and has not come to its command. */
interface Unbegun {
  readonly componentRef: string;
  stopped: boolean;
}

export class Stops {
  readonly #onStop: (isStopped: IsStopped) => void;
  readonly #unbegun = new Set<Unbegun>();
  /** The engines that this client is stopping; undefined for all. */
  readonly #stopping = new Set<{ readonly engineId: string | undefined }>();

  /** @param onStop is called when what acts on an engine is stopped */
  constructor(onStop: (isStopped: IsStopped) => void) {
    this.#onStop = onStop;
  }

  /**
   * Does what has to come before a command, such as binding its component.
   *
   * @param undo is called with what came of it where the component was stopped meanwhile
   * @throws CommandFailed (ABORT: it was stopped before it began) | what `prepare` throws
   */
  async unlessStopped<T>(
    componentRef: string,
    prepare: () => Promise<T>,
    undo: (prepared: T) => Promise<void> | void = () => undefined,
  ): Promise<T> {
    const work = { componentRef, stopped: false };
    this.#unbegun.add(work);
    try {
      const prepared = await prepare();
      if (!work.stopped) return prepared;
      await undo(prepared);
    } finally {
      this.#unbegun.delete(work);
    }
    throw new CommandFailed(`work with ${componentRef}`, "", "ABORT", "it was stopped before it began");
  }

  /** Notes that one component is stopped. */
  stopComponent(stopped: string): void {
    this.#note((componentRef) => componentRef === stopped);
  }

  /** Stops an engine, or all of them: from now on, what has not begun does not. */
  async stopEngine<T>(engineId: string | undefined, stop: () => Promise<T>): Promise<T> {
    const own = { engineId };
    this.#stopping.add(own);
    this.#noteEngine(engineId);
    try {
      return await stop();
    } finally {
      this.#stopping.delete(own);
    }
  }

  /** Takes the gateway's word that a person has stopped an engine. */
  handleStopped(engineId: string): void {
    // It tells of this client's own STOP, too: what was asked for since then is meant.
    for (const own of this.#stopping) if ((own.engineId ?? engineId) === engineId) return;
    this.#noteEngine(engineId);
  }

  #noteEngine(engineId: string | undefined): void {
    const isStopped: IsStopped = (ref) => engineId === undefined || ref.startsWith(`${engineId}/`);
    this.#note(isStopped);
    this.#onStop(isStopped);
  }

  #note(isStopped: IsStopped): void {
    for (const work of this.#unbegun) work.stopped ||= isStopped(work.componentRef);
  }
}
