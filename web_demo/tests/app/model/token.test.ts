import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { PageToken, asksForTokens } from "../../../app/model/token.ts";

const TOKEN = "eyJh.eyJz.c2ln_-";

class Store {
  text: string | null = null;
  closed = false;
  getItem(): string | null {
    if (this.closed) throw new DOMException("", "SecurityError");
    return this.text;
  }
  setItem(_: string, text: string): void {
    if (this.closed) throw new DOMException("", "SecurityError");
    this.text = text;
  }
}

describe("the page's token", () => {
  it("is kept for the tab", () => {
    const store = new Store();
    const token = new PageToken(store);
    expect(token.value).toBeUndefined();
    expect(token.give(`  Bearer ${TOKEN}\n`)).toBe(true);
    expect(token.value).toBe(TOKEN);
    expect(new PageToken(store).value).toBe(TOKEN);
  });

  it.each(["", "a", "a.b", "a.b.c.d", "a.b.c d", "a,b.c.d", "ä.b.c", `${"a".repeat(6144)}.b.c`])(
    "is not %s",
    (text) => {
      const store = new Store();
      const token = new PageToken(store);
      token.give(TOKEN);
      expect(token.give(text)).toBe(false);
      expect(token.value).toBe(TOKEN);
      store.text = text;
      expect(new PageToken(store).value).toBeUndefined();
    },
  );

  it("comes out of the address, and stands there no more", () => {
    const token = new PageToken(new Store());
    const history = { replaceState: vi.fn() };
    token.readFrom({ hash: `#token=${TOKEN}`, pathname: "/page", search: "?a" }, history);
    expect(token.value).toBe(TOKEN);
    expect(history.replaceState).toHaveBeenCalledWith(null, "", "/page?a");
    token.readFrom({ hash: "#inspector/token=x.y.z", pathname: "/", search: "" }, history);
    expect(history.replaceState).toHaveBeenCalledTimes(1);
    token.readFrom({ hash: "#token=nonsense", pathname: "/", search: "" }, history);
    expect(history.replaceState).toHaveBeenCalledTimes(2);
    expect(token.value).toBe(TOKEN);
  });

  it.each([
    [{ roles: "viewer" }, false],
    [{ roles: ["viewer", "maintenance"] }, false],
    [{ roles: ["viewer", "operator"] }, true],
    [{ roles: "administrator" }, true],
    [{}, true],
    [null, true],
    [{ roles: [7], sub: "Zoë ~~~???" }, false],
  ])("says of %j whether its bearer may operate: %s", (claims, expected) => {
    const token = new PageToken(new Store());
    expect(token.mayOperate).toBe(true);
    const bytes = new TextEncoder().encode(JSON.stringify(claims));
    const payload = btoa(String.fromCharCode(...bytes))
      .replaceAll("+", "-")
      .replaceAll("/", "_");
    token.give(`e30.${payload.replaceAll("=", "")}.c2ln`);
    expect(token.mayOperate).toBe(expected);
  });

  it("ranks where it names a rank, and the gateway goes by it", () => {
    const token = new PageToken(new Store());
    expect(token.ranks).toBe(false);
    token.give(TOKEN);
    expect(token.ranks).toBe(false);
    token.give(`e30.${btoa('{"rank":"person"}').replaceAll("=", "")}.c2ln`);
    expect(token.ranks).toBe(true);
    token.asked = false;
    expect(token.ranks).toBe(false);
  });

  it.each([
    [{ roles: "visitor" }, true],
    [{ roles: ["operator", "visitor"] }, true],
    [{ roles: ["operator", "viewer"] }, false],
    [{}, false],
  ])("says of %j whether its bearer sends without control: %s", (claims, expected) => {
    const token = new PageToken(new Store());
    expect(token.visits).toBe(false);
    token.give(`e30.${btoa(JSON.stringify(claims)).replaceAll("=", "")}.c2ln`);
    expect(token.visits).toBe(expected);
    token.asked = false;
    expect(token.visits).toBe(false);
  });

  it("counts where the gateway asks for one, and bars no action elsewhere", () => {
    const token = new PageToken(new Store());
    expect(token.counts).toBe(false);
    token.give(`e30.${btoa('{"roles":"viewer"}').replaceAll("=", "")}.c2ln`);
    expect([token.counts, token.mayOperate]).toEqual([true, false]);
    token.asked = false;
    expect([token.counts, token.mayOperate]).toEqual([false, true]);
  });

  it.each([
    ['{"status": "ok", "tokens": false}', false],
    ['{"status": "ok", "tokens": true}', true],
    ['{"status": "ok"}', true],
    ["null", true],
    ["nonsense", true],
    [null, true],
  ])("is asked for by a gateway that says %s: %s", async (body, expected) => {
    const fetched = vi.fn(() =>
      body === null ? Promise.reject(new TypeError()) : Promise.resolve(new Response(body)),
    );
    vi.stubGlobal("fetch", fetched);
    expect(await asksForTokens(TOKEN)).toBe(expected);
    expect(fetched.mock.calls[0]).toMatchObject([
      "admitted",
      { headers: { Authorization: `Bearer ${TOKEN}` } },
    ]);
    vi.unstubAllGlobals();
  });

  describe("of a gateway that gives its page one", () => {
    const answers: (Response | Error)[] = [];
    const shown: (string | undefined)[] = [];
    const given = (token: unknown, status = 200): Response => Response.json({ token }, { status });

    beforeEach(() => {
      answers.length = shown.length = 0;
      vi.stubGlobal("fetch", async (path: string, { headers }: { headers: Record<string, string> }) => {
        expect(path).toBe("page-token");
        shown.push(headers["Authorization"]);
        const answer = answers.shift();
        if (answer instanceof Response) return answer;
        throw answer ?? new Error("it was asked too often");
      });
    });

    afterEach(() => void vi.unstubAllGlobals());

    it("is asked for, and for another one of the same visitor while it is good", async () => {
      const token = new PageToken(new Store());
      answers.push(given(TOKEN, 201), given(`${TOKEN}2`));
      expect([await token.obtain(), token.value]).toEqual([true, TOKEN]);
      expect([await token.obtain(), token.value]).toEqual([false, `${TOKEN}2`]);
      expect(shown).toEqual([undefined, `Bearer ${TOKEN}`]);
    });

    it("is another visitor's where the gateway has not given the former one", async () => {
      const token = new PageToken(new Store());
      token.give(TOKEN);
      answers.push(given(`${TOKEN}2`, 201));
      expect([await token.obtain(), token.value]).toEqual([true, `${TOKEN}2`]);
      expect(shown).toEqual([`Bearer ${TOKEN}`]);
    });

    it.each([
      ["gives none", new Response(null, { status: 204 })],
      ["is another server", new Response("", { status: 404 })],
      ["says nonsense", given(7)],
      ["is away", new TypeError()],
    ])("stays what it was where the gateway %s", async (_, answer) => {
      const token = new PageToken(new Store());
      token.give(TOKEN);
      answers.push(answer);
      expect([await token.obtain(), token.value]).toEqual([false, TOKEN]);
      expect(shown).toHaveLength(1);
    });
  });

  it("knows when it has ended, where it can be read", () => {
    const token = new PageToken(new Store());
    expect(token.hasEnded(1e15)).toBe(false);
    token.give(TOKEN);
    expect(token.hasEnded(1e15)).toBe(false);
    token.give(`e30.${btoa('{"exp": 100}').replaceAll("=", "")}.c2ln`);
    expect([token.hasEnded(99_999), token.hasEnded(100_000)]).toEqual([false, true]);
  });

  it("holds without a place to keep it", () => {
    const store = new Store();
    store.closed = true;
    const token = new PageToken(store);
    expect(token.give(TOKEN)).toBe(true);
    expect(token.value).toBe(TOKEN);
  });
});
