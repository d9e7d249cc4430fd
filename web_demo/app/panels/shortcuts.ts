/** The page's keyboard shortcuts, and their list. */

import { byRole, make } from "../dom/elements.ts";

export interface Shortcut {
  readonly keys: readonly string[];
  readonly label: string;
  run(key: string): void;
}

/**
 * Keys work everywhere but in fields, which have keys of their own; there only Escape does, which also leaves the field.
 * STOP is pressed in `StopButton`, wherever no text is typed.
 */
export function installShortcuts(shortcuts: readonly Shortcut[]): void {
  const dialog = byRole("help", HTMLDialogElement);
  const help: Shortcut = { keys: ["?"], label: "This list", run: () => dialog.showModal() };
  const all = [...shortcuts, help];
  byRole("help-open", HTMLButtonElement).addEventListener("click", () => help.run("?"));
  const rows = all.flatMap(({ keys, label }) => [
    make("dt", {}, ...keysShown(keys).map((key) => make("kbd", {}, key))),
    make("dd", {}, label),
  ]);
  byRole("help-list", HTMLElement).append(...rows);
  // Enter that is held down presses once: what it does again and again would outlast a STOP.
  document.addEventListener(
    "keydown",
    (event) => {
      if (event.key !== "Enter" || !event.repeat) return;
      event.preventDefault();
      event.stopPropagation();
    },
    { capture: true },
  );
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const target = event.target instanceof HTMLElement ? event.target : document.body;
    if (target.matches("input, textarea, select")) {
      if (event.key !== "Escape") return;
      target.blur();
    }
    const found = all.find(({ keys }) => keys.includes(event.key));
    if (!found || event.repeat) return;
    event.preventDefault();
    found.run(event.key);
  });
}

/** A row of digits is shown by its ends. */
function keysShown(keys: readonly string[]): string[] {
  const [first, last] = [keys[0], keys.at(-1)];
  return keys.length > 2 ? [`${first}`, "…", `${last}`] : [...keys];
}
