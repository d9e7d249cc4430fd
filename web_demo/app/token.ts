/** The token with which the page comes to its gateway: given by hand or in the address, and kept for this tab. */

const KEY = "openrois.token";
/** The parts of a JSON Web Token, and nothing that a subprotocol's name must not have. */
const SHAPE = /^[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+$/;

/** What a browser keeps for one tab at one address, until the tab is closed. */
type Store = Pick<Storage, "getItem" | "setItem">;

export class PageToken {
  readonly #store: Store;
  #value: string | undefined;

  constructor(store: Store) {
    this.#store = store;
    try {
      this.#value = shaped(store.getItem(KEY) ?? "");
    } catch {
      // Forbidden: a token that is given holds until the page is loaded again.
    }
  }

  get value(): string | undefined {
    return this.#value;
  }

  /** Keeps a token; returns false for a text that is none. */
  give(text: string): boolean {
    const token = shaped(text);
    if (token === undefined) return false;
    this.#value = token;
    try {
      this.#store.setItem(KEY, token);
    } catch {
      // As above.
    }
    return true;
  }

  /**
   * Takes the token out of the address, `#token=…`: browsers send this part to nobody, and where it does not stand any
   * more it is in no history and no bookmark.
   */
  takeFrom(
    location: Pick<Location, "hash" | "pathname" | "search">,
    history: Pick<History, "replaceState">,
  ): void {
    const given = /^#token=([^&]*)$/.exec(location.hash)?.[1];
    if (given === undefined) return;
    this.give(given);
    history.replaceState(null, "", `${location.pathname}${location.search}`);
  }
}

function shaped(text: string): string | undefined {
  const token = text.trim().replace(/^Bearer /i, "");
  return token.length <= 6144 && SHAPE.test(token) ? token : undefined;
}

/** Whether the gateway is there although it does not let the page in: then it is a token that is missing. */
export async function gatewayIsThere(): Promise<boolean> {
  try {
    return (await fetch("healthz", { cache: "no-store", signal: AbortSignal.timeout(5000) })).ok;
  } catch {
    return false;
  }
}
