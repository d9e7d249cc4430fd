/** The buttons for the avatar's reactions. */

import { Reaction } from "../../sdk/index.ts";
import type { Client } from "../../sdk/index.ts";
import { ComponentWatch, isUsable } from "../model/component_status.ts";
import { byRole, byTestId, icon, make } from "../dom/elements.ts";
import { describeEnd } from "../model/outcome.ts";
import { PassingText } from "../dom/passing_text.ts";
import { explain } from "../model/permission.ts";
import { bestColumns, reactionLook } from "../model/reaction_looks.ts";

const BUSY = "another visitor is moving the body; try again in a moment";

export class Reactions {
  readonly #client: Client;
  readonly #section = byRole("reactions-section", HTMLElement);
  readonly #grid = byRole("reactions", HTMLElement);
  readonly #state = new PassingText(byTestId("reaction-state", HTMLElement));
  readonly #watch: ComponentWatch;
  #reaction: Reaction | null = null;
  #shown = "";
  #performance = 0;
  #usable = false;
  #barred = "";

  constructor(client: Client) {
    this.#client = client;
    this.#watch = new ComponentWatch(client, (status) => {
      this.#usable = isUsable(status);
      this.#render();
      return this.#usable ? this.#fill() : undefined;
    });
  }

  /** Whether the avatar has reactions at all, now or when it is back. */
  set offered(offered: boolean) {
    this.#section.hidden = !offered || this.#buttons.length === 0;
  }

  /** Why no reaction can be asked for; empty where it can. */
  set barred(barred: string) {
    this.#barred = barred;
    this.#render();
  }

  /** @param componentRef the Reaction component; null when the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    if (componentRef !== null && this.#reaction?.componentRef !== componentRef) {
      this.#reaction = new Reaction(this.#client, componentRef);
    }
    this.#watch.watch(componentRef);
  }

  /** Performs the reaction of the button with this index, from 0. */
  press(index: number): void {
    this.#buttons[index]?.click();
  }

  #render(): void {
    for (const button of this.#buttons) {
      button.disabled = !this.#usable || this.#barred !== "";
      explain(button, this.#barred);
    }
  }

  get #buttons(): HTMLButtonElement[] {
    return [...this.#grid.querySelectorAll("button")];
  }

  async #fill(): Promise<void> {
    const reaction = this.#reaction;
    if (!reaction) return;
    try {
      const { available_reactions: refs } = await reaction.availableReactions();
      // Buttons that are the same stay, and with them the keyboard's focus.
      if (refs.join() === this.#shown && this.#buttons.length > 0) return;
      this.#shown = refs.join();
      this.#grid.replaceChildren(...refs.map((ref, index) => this.#button(ref, index)));
      this.#grid.style.setProperty("--columns", String(bestColumns(refs.length, [6, 5, 7])));
      this.#grid.style.setProperty("--columns-narrow", String(bestColumns(refs.length, [4, 5, 3])));
      this.#render();
      this.#state.show("", false);
      this.#section.hidden = refs.length === 0;
    } catch (error) {
      this.#state.show("The reactions could not be read. The page tries again.", false);
      throw error;
    }
  }

  #button(reactionRef: string, index: number): HTMLButtonElement {
    const { code, name, path } = reactionLook(reactionRef);
    const button = make(
      "button",
      { type: "button", class: "reaction", "data-testid": `reaction-${code}`, title: name },
      icon(path),
      make("span", {}, name),
    );
    // The keys 1 to 9, then 0.
    if (index < 10) button.append(make("kbd", { "aria-hidden": "true" }, String((index + 1) % 10)));
    button.addEventListener("click", () => void this.#perform(button, reactionRef, name));
    return button;
  }

  async #perform(button: HTMLButtonElement, reactionRef: string, name: string): Promise<void> {
    const reaction = this.#reaction;
    if (!reaction || button.disabled) return;
    const performance = ++this.#performance;
    button.setAttribute("aria-busy", "true");
    this.#state.show(`${name} …`, false);
    const { text: words } = await describeEnd(reaction.perform({ reaction_ref: reactionRef }), BUSY);
    if (performance === this.#performance) this.#state.show(`${name}: ${words}`, true);
    // Pressed twice, a reaction runs until the second has ended.
    if (performance === this.#performance || !reaction.inUse) this.#idle();
    else button.removeAttribute("aria-busy");
  }

  #idle(): void {
    for (const button of this.#buttons) button.removeAttribute("aria-busy");
  }
}
