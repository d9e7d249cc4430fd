/** Strip with the holder of control: visitors request it there, and the holder answers. */

import type { BodyControl, GiveBack } from "../model/body_control.ts";
import { byRole, byTestId, setText } from "../dom/elements.ts";
import { amid, named } from "../model/plain_words.ts";
import { WATCHING } from "../model/permission.ts";

type Press = () => Promise<unknown>;
type Choice = readonly [words: string, press: Press];

export class Handover {
  readonly #body: BodyControl;
  /** Begins to drive with control that was granted; returns false where there is nothing to drive. */
  readonly #drive: (giveBack: GiveBack) => boolean;
  readonly #bar: HTMLElement;
  readonly #words: HTMLElement;
  readonly #yes: HTMLButtonElement;
  readonly #no: HTMLButtonElement;
  /** Gives back what was granted without anything to drive. */
  #giveBack: GiveBack | null = null;
  #held = "";
  #watching = false;
  #shown = false;
  #press: { readonly yes: Press | null; readonly no: Press | null } = { yes: null, no: null };

  constructor(body: BodyControl, drive: (giveBack: GiveBack) => boolean, root: ParentNode) {
    this.#body = body;
    this.#drive = drive;
    this.#bar = byTestId("handover", HTMLElement, root);
    this.#words = byRole("handover-words", HTMLElement, root);
    this.#yes = byTestId("handover-yes", HTMLButtonElement, root);
    this.#no = byTestId("handover-no", HTMLButtonElement, root);
    this.#yes.addEventListener("click", (event) => this.#pressed(event, this.#press.yes));
    this.#no.addEventListener("click", (event) => this.#pressed(event, this.#press.no));
  }

  /** What control is held for, in a sentence, as long as it is; empty for nothing. */
  set held(held: string) {
    this.#held = held;
    this.render();
  }

  /** Whether the visitor may only watch; the strip says so, without a button. */
  set watching(watching: boolean) {
    this.#watching = watching;
    this.render();
  }

  /** Whether there is an avatar that can be controlled now. */
  set shown(shown: boolean) {
    this.#shown = shown;
    this.render();
  }

  render(): void {
    const { state, nextRequest } = this.#body;
    if (state.kind !== "mine") this.#giveBack = null;
    if (!this.#shown) return this.#hide();
    if (this.#watching) return this.#show(WATCHING, null, null);
    if (nextRequest) return this.#ask(nextRequest.subject, nextRequest.more);
    switch (state.kind) {
      case "mine":
        return this.#has(state.lender);
      case "free":
        return this.#hide();
      case "other": {
        const away = state.absent ? ", whose connection is lost," : "";
        const take: Choice = state.mayTakeOver
          ? ["Take over", () => this.#begin(this.#body.takeOver())]
          : ["Ask for it", () => this.#begin(this.#body.requestControl())];
        return this.#show(`${named(state.holder)}${away} has control`, take, null);
      }
      case "waiting":
        return this.#wait(named(state.holder), state.position, state.declined);
    }
  }

  /** The second press of a double click was not meant for what stands there after the first. */
  #pressed({ detail }: MouseEvent, press: Press | null): void {
    if (detail < 2) void press?.().catch(() => this.render());
  }

  #ask(subject: string, more: number): void {
    const others = more > 0 ? `, and ${more} more` : "";
    this.#show(
      `${subject} asks for control${others}`,
      ["Hand over", () => this.#body.answerRequest(true)],
      ["Keep", () => this.#body.answerRequest(false)],
    );
  }

  /** While the avatar is driven the picture says so. @param lender has it back afterwards; empty for none */
  #has(lender: string): void {
    const handBack: Press = async () => this.#body.handBack();
    if (lender !== "")
      return this.#show(`You have control in place of ${amid(named(lender))}`, null, ["Hand back", handBack]);
    if (this.#held !== "") return this.#show(this.#held, null, null);
    if (!this.#giveBack) return this.#hide();
    const giveBack: Press = async () => {
      this.#giveBack?.();
      this.#giveBack = null;
      this.render();
    };
    this.#show("You have control", null, ["Give back", giveBack]);
  }

  #wait(holder: string, position: number, declined: boolean): void {
    const leave: Choice = ["Leave", () => this.#body.leaveLine()];
    const line = `number ${position} in line`;
    if (!declined) return this.#show(`You wait for control: ${line}`, null, leave);
    const again: Choice = ["Ask again", () => this.#body.askAgain()];
    this.#show(`${holder} does not hand over control now. You wait: ${line}`, again, leave);
  }

  /** Begins to drive with control once it is granted or taken; where the body was stopped meanwhile, it is only held. */
  async #begin(control: Promise<GiveBack>): Promise<void> {
    const { stops } = this.#body;
    const giveBack = await control;
    if (stops !== this.#body.stops || !this.#drive(giveBack)) this.#giveBack = giveBack;
    this.render();
  }

  #hide(): void {
    this.#bar.hidden = true;
  }

  #show(words: string, yes: Choice | null, no: Choice | null): void {
    this.#bar.classList.toggle("asking", this.#body.nextRequest !== null);
    setText(this.#words, words);
    setText(this.#yes, yes?.[0] ?? "");
    setText(this.#no, no?.[0] ?? "");
    this.#yes.hidden = yes === null;
    this.#no.hidden = no === null;
    this.#press = { yes: yes?.[1] ?? null, no: no?.[1] ?? null };
    this.#bar.hidden = false;
  }
}
