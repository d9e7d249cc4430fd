/** The token with which the page comes to its gateway: given by hand or in the address, and kept for this tab. */

const KEY = "openrois.token";
/** The parts of a JSON Web Token, and nothing that a subprotocol's name must not have. */
const SHAPE = /^[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+$/;

/** The status of an answer with the first token of a visitor. */
const CREATED = 201;

/** What a browser keeps for one tab at one address, until the tab is closed. */
type Store = Pick<Storage, "getItem" | "setItem">;

export class PageToken {
  readonly #store: Store;
  #value: string | undefined;
  /** Whether the gateway asks for tokens; without that, roles in a token have no effect. */
  asked = true;

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

  /** Whether it is there, and the gateway goes by it. */
  get counts(): boolean {
    return this.#value !== undefined && this.asked;
  }

  /** Whether it names a rank, with which its bearer may go before others; without one it ranks lowest. */
  get ranks(): boolean {
    const { rank } = claimsOf(this.#value ?? "");
    return this.counts && typeof rank === "string" && rank !== "";
  }

  /** Whether it lets its bearer operate, as far as a page can read it; the gateway decides. */
  get mayOperate(): boolean {
    const { roles = "" } = claimsOf(this.#value ?? "");
    if (!this.counts || roles === "") return true;
    return [roles].flat().some((role) => role === "operator" || role === "administrator");
  }

  /** Whether it lets its bearer send microphone and camera without control; where none counts, control is not asked for. */
  get visits(): boolean {
    const { roles = "" } = claimsOf(this.#value ?? "");
    return this.counts && [roles].flat().includes("visitor");
  }

  /** @param now milliseconds since the epoch */
  hasEnded(now: number): boolean {
    const { exp } = claimsOf(this.#value ?? "");
    return typeof exp === "number" && exp * 1000 <= now;
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
   * Gets a token from a gateway that gives its page one, as that of the demo does: another one of the same visitor where it
   * has one that is still good. Returns whether the page is another visitor by it: it had none, or one of before the
   * gateway was started.
   */
  async obtain(): Promise<boolean> {
    try {
      const response = await ask("page-token", this.#value);
      if (response.status !== 200 && response.status !== CREATED) return false;
      return this.give(tokenOf(await response.json())) && response.status === CREATED;
    } catch {
      return false;
    }
  }

  /**
   * Reads the token from the address, `#token=…`, and removes it there: browsers send this part to no server, and a
   * removed one gets into no history and no bookmark.
   */
  readFrom(
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

/** What a token says of itself; nothing where it cannot be read. */
function claimsOf(token: string): {
  readonly roles?: unknown;
  readonly exp?: unknown;
  readonly rank?: unknown;
} {
  const [, payload = ""] = token.split(".");
  try {
    const claims: unknown = JSON.parse(atob(payload.replaceAll("-", "+").replaceAll("_", "/")));
    return typeof claims === "object" && claims !== null ? claims : {};
  } catch {
    return {};
  }
}

/**
 * Whether the gateway is reached and refuses this token, or a page without one. A browser hides why a WebSocket was refused; a
 * plain request with the same token is answered.
 */
export async function isTurnedAway(token: string | undefined): Promise<boolean> {
  const status = await admission(token).then(
    (response) => response.status,
    () => 0,
  );
  return status === 401 || status === 403;
}

/** Whether the gateway asks for tokens; assumed where it does not say. */
export async function asksForTokens(token: string): Promise<boolean> {
  try {
    const said: unknown = await (await admission(token)).json();
    return !(typeof said === "object" && said !== null && "tokens" in said && said.tokens === false);
  } catch {
    return true;
  }
}

function admission(token: string | undefined): Promise<Response> {
  return ask("admitted", token);
}

function ask(path: string, token: string | undefined): Promise<Response> {
  const headers: Record<string, string> = token === undefined ? {} : { Authorization: `Bearer ${token}` };
  return fetch(path, { cache: "no-store", headers, signal: AbortSignal.timeout(5000) });
}

function tokenOf(answer: unknown): string {
  const isToken = typeof answer === "object" && answer !== null && "token" in answer;
  return isToken && typeof answer.token === "string" ? answer.token : "";
}
