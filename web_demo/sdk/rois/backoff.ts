/** Exponential backoff with jitter, so that a thousand clients do not reconnect at once. */

export interface BackoffOptions {
  /** Milliseconds before the first retry. */
  readonly first?: number;
  readonly factor?: number;
  /** The most milliseconds between two attempts. */
  readonly max?: number;
  /** Returns a number in [0, 1). */
  readonly random?: () => number;
}

/** The waits between attempts: the upper end grows by `factor`, the wait is anything up to it. */
export class Backoff {
  readonly #options: Required<BackoffOptions>;
  #failures = 0;

  constructor(options: BackoffOptions = {}) {
    this.#options = { first: 500, factor: 1.5, max: 10_000, random: Math.random, ...options };
  }

  /** Number of waits since the last reset. */
  get failures(): number {
    return this.#failures;
  }

  /** Returns the milliseconds to wait after one more failure. */
  next(): number {
    const { first, factor, max, random } = this.#options;
    const ceiling = Math.min(max, first * factor ** this.#failures);
    this.#failures += 1;
    return Math.round(ceiling * random());
  }

  reset(): void {
    this.#failures = 0;
  }
}
