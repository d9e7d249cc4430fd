import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { DialogueCard } from "../../../app/panels/dialogue.ts";
import type { PageBody } from "../../../app/model/bodies.ts";
import { FakeElement, stubPage } from "../../support/elements.ts";

let subscribed: Map<string, (value: object) => void>;
let parameters: object;

vi.mock("../../../sdk/index.ts", () => {
  class RoISCommon {
    readonly #ref: string;
    constructor(_client: unknown, ref: string) {
      this.#ref = ref;
    }
    event(name: string): object {
      return {
        subscribe: async (listener: (value: object) => void) => {
          subscribed.set(`${this.#ref} ${name}`, listener);
          return { cancel: async () => void subscribed.delete(`${this.#ref} ${name}`) };
        },
      };
    }
    getParameter = async (): Promise<object> => parameters;
  }
  return { RoISCommon };
});

beforeEach(() => {
  subscribed = new Map();
  parameters = {};
});
afterEach(() => {
  vi.unstubAllGlobals();
});

const BODY = { engineId: "a", hearing: "a/h", progress: "a/p", dialogue: "a/d" } as unknown as PageBody;

/** Returns the card, its elements, and what it consented to. */
function made(agreed: string[] = ["recognition"]) {
  const find = stubPage();
  Object.assign(FakeElement.prototype, { children: [], insertBefore: () => undefined });
  const microphone = {
    control: { isOn: false, toggle: async () => undefined, off: async () => undefined },
    stream: { muted: false, status: null },
  };
  const card = new DialogueCard({} as never, {
    microphone: () => microphone,
    microphoneBarred: () => "",
    visitorRef: () => "a/visitor/me",
    missing: (purposes) => purposes.filter((each) => !agreed.includes(each)),
    consentTo: (purposes) => void agreed.push(...purposes),
    speaker: () => "a",
  });
  return { card, find, agreed, microphone };
}

const settled = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));

it("says before a person speaks where words would go, and consents to what is missing in one press", async () => {
  parameters = { sent_to: "https://model.example", can_be_said: ["wave"] };
  const { card, find, agreed } = made();
  card.setBody(BODY);
  await settled();
  expect(find("dialogue-sent-to").textContent).toContain("would be sent to https://model.example");
  expect(find("dialogue-agree-words").textContent).toBe(
    "To be answered, let the body pass them to the program that answers and send them to that machine.",
  );
  find("dialogue-agree-button").click();
  expect(agreed).toEqual(["recognition", "agent", "transfer"]);
  expect(find("dialogue-agree").hidden).toBe(true);
  expect(find("dialogue-sent-to").textContent).toBe(
    "To be answered, what you say is sent to https://model.example.",
  );
});

it("lets words be recognised only for a program that converses, or while the button is held", async () => {
  const { card, find } = made();
  card.setBody(BODY);
  await settled();
  expect(subscribed.has("a/h heard")).toBe(false);
  const key = (name: string): void =>
    void find("talk").dispatchEvent(Object.assign(new Event(name), { key: " ", repeat: false }));
  key("keydown");
  await settled();
  expect([subscribed.has("a/h heard"), find("talk").textContent]).toEqual([true, "Connecting …"]);
  find("talk").dispatchEvent(new Event("blur"));
  await settled();
  expect([subscribed.has("a/h heard"), find("talk").textContent]).toEqual([true, "Hold to talk"]);
  card.setBody(null);
  await settled();
  expect(subscribed.has("a/h heard")).toBe(false);
  subscribed.get("a/d changed")?.({ sent_to: "", can_be_said: [], wake_word: "computer" });
  await settled();
  expect([subscribed.has("a/h heard"), find("talk").hidden]).toEqual([true, true]);
});
