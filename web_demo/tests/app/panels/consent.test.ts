import { afterEach, expect, it, vi } from "vitest";
import { ConsentPanel } from "../../../app/panels/consent.ts";
import { FakeElement } from "../../support/elements.ts";

vi.mock("../../../sdk/index.ts", () => ({}));

afterEach(() => {
  vi.unstubAllGlobals();
});

/** Returns a panel, its elements in the order in which they were made, and what it said. */
function made(): { panel: ConsentPanel; elements: FakeElement[]; said: string[] } {
  const elements: FakeElement[] = [];
  vi.stubGlobal("document", {
    createElement: (tag: string) => {
      const element = new FakeElement(tag);
      elements.push(element);
      return element;
    },
  });
  const said: string[] = [];
  const panel = new ConsentPanel(
    () => said.push(`changed to ${panel.purposes.join()}`),
    () => said.push(`withdrawn, left ${panel.purposes.join()}`),
  );
  return { panel, elements, said };
}

const named = (elements: FakeElement[], name: string): FakeElement & { checked: boolean } =>
  elements.find((element) => element.getAttribute("data-testid") === name) as FakeElement & {
    checked: boolean;
  };

it("has at first chosen what was done before there was a choice", () => {
  expect(made().panel.purposes).toEqual(["live", "recognition"]);
});

it("says what is chosen, shows it while something is sent, and withdraws it in one press", () => {
  const { panel, elements, said } = made();
  const strip = elements.find((element) => element.getAttribute("role") === "status");
  expect(strip?.hidden).toBe(true);
  panel.sending = true;
  expect(strip?.hidden).toBe(false);
  const box = named(elements, "consent-agent");
  box.checked = true;
  box.dispatchEvent(new Event("change"));
  expect(named(elements, "consent-words").textContent).toBe(
    "You may be heard and seen live, recognised and passed to a program that answers.",
  );
  named(elements, "consent-withdraw").click();
  expect(said).toEqual(["changed to live,recognition,agent", "withdrawn, left "]);
  expect(panel.purposes).toEqual([]);
  panel.sending = false;
  expect([strip?.hidden, named(elements, "consent-withdraw").hidden]).toEqual([false, true]);
  expect(named(elements, "consent-words").textContent).toBe(
    "Microphone and camera stay off until you choose what they may be used for.",
  );
  const live = named(elements, "consent-live");
  live.checked = true;
  live.dispatchEvent(new Event("change"));
  expect(strip?.hidden).toBe(true);
});

it("consents to more where that is asked for", () => {
  const { panel, elements } = made();
  panel.add(["agent", "transfer"]);
  expect(panel.purposes).toEqual(["live", "recognition", "agent", "transfer"]);
  expect(named(elements, "consent-transfer").checked).toBe(true);
});
