import { describe, expect, it } from "vitest";
import { recall, remember } from "../../../app/model/memory.ts";
import type { Remembered } from "../../../app/model/memory.ts";

const PAGE: Remembered = {
  engineId: "avatar",
  video: "suspended",
  audio: "running",
  muted: true,
  statistics: true,
  picture: "data:image/jpeg;base64,AAAA",
};

class Store {
  text: string | null = null;
  full = false;
  getItem(): string | null {
    return this.text;
  }
  setItem(_: string, text: string): void {
    if (this.full) throw new DOMException("", "QuotaExceededError");
    this.text = text;
  }
}

describe("what the page remembers", () => {
  it("comes back as it was", () => {
    const store = new Store();
    expect(recall(store, 0)).toBeNull();
    remember(store, PAGE, 1000);
    expect(recall(store, 2000)).toEqual(PAGE);
  });

  it.each([40_000, 500])("has no picture that is old, or from the future: at %s", (now) => {
    const store = new Store();
    remember(store, PAGE, 1000);
    expect(recall(store, now)).toEqual({ ...PAGE, picture: "" });
  });

  it.each([
    "[",
    "7",
    "{}",
    '{"engineId": 1}',
    '{"engineId": "a", "video": "flying"}',
    '{"engineId": "a", "audio": []}',
  ])("is passed over when it is not understood: %s", (text) => {
    const store = new Store();
    store.text = text;
    expect(recall(store, 0)).toBeNull();
  });

  it("takes what is missing for the usual, and no address for a picture", () => {
    const store = new Store();
    store.text = '{"engineId": "a", "picture": "https://elsewhere/"}';
    const usual = { video: "running", audio: "running", muted: false, statistics: false, picture: "" };
    expect(recall(store, 0)).toEqual({ engineId: "a", ...usual });
  });

  it("may be nothing where the browser keeps nothing", () => {
    const store = new Store();
    store.full = true;
    remember(store, PAGE, 0);
    expect(store.text).toBeNull();
  });
});
