import { afterEach, expect, it, vi } from "vitest";
import { installShortcuts } from "../../../app/panels/shortcuts.ts";
import { stubPage } from "../../support/elements.ts";
import { happen } from "../../support/fake_page.ts";

afterEach(() => {
  vi.unstubAllGlobals();
});

it("keys that are held down are pressed once", () => {
  stubPage();
  vi.stubGlobal("HTMLDialogElement", HTMLElement);
  vi.stubGlobal("document", Object.assign(document, { body: { matches: () => false } }));
  const run = vi.fn();
  installShortcuts([{ keys: ["1"], label: "A reaction", run }]);
  for (const repeat of [false, true, true]) happen(document, "keydown", { key: "1", repeat });
  expect(run).toHaveBeenCalledOnce();
  const presses = [false, true, true].map((repeat) => happen(document, "keydown", { key: "Enter", repeat }));
  expect(presses.map(({ defaultPrevented }) => defaultPrevented)).toEqual([false, true, true]);
});
