/** Who has control of the avatar: one may ask for it, and whoever has it is asked. */

import type { Client, LeaseRequestedNotification, LeaseStatus } from "../sdk/index.ts";
import { byRole, byTestId, setText } from "./dom.ts";
import { WATCHING } from "./permission.ts";

type Press = () => Promise<unknown>;

export class Handover {
  readonly #client: Client;
  readonly #bar = byTestId("handover", HTMLElement);
  readonly #words = byRole("handover-words", HTMLElement);
  readonly #yes = byTestId("handover-yes", HTMLButtonElement);
  readonly #no = byTestId("handover-no", HTMLButtonElement);
  #componentRef: string | null = null;
  #asked: LeaseRequestedNotification | null = null;
  #answering: ReturnType<typeof setTimeout> | undefined;
  #held = "";
  #watching = false;
  #press: { readonly yes: Press | null; readonly no: Press | null } = { yes: null, no: null };

  constructor(client: Client) {
    this.#client = client;
    this.#yes.addEventListener("click", () => void this.#press.yes?.().catch(() => this.#look()));
    this.#no.addEventListener("click", () => void this.#press.no?.().catch(() => this.#look()));
    client.control.on("openrois.lease.requested", (asked) => this.#ask(asked));
    client.control.on("openrois.lease.withdrawn", ({ request_id }) => this.#done(request_id));
    client.control.on("openrois.lease.changed", (told) => {
      if (told.component_ref === this.#componentRef) this.#changed(told);
    });
  }

  /** @param componentRef whoever holds this component drives; null while the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    if (componentRef === this.#componentRef) return;
    this.#componentRef = componentRef;
    this.#asked = null;
    void this.#look();
  }

  /** What control is held for, in a sentence, as long as it is; empty for nothing. */
  set held(held: string) {
    if (held === this.#held) return;
    this.#held = held;
    void this.#look();
  }

  /** Whoever only watches asks for nothing, and is told so. */
  set watching(watching: boolean) {
    if (watching === this.#watching) return;
    this.#watching = watching;
    void this.#look();
  }

  async #look(): Promise<void> {
    if (this.#watching) return this.#show(WATCHING, null, null);
    const componentRef = this.#componentRef;
    if (componentRef === null) return this.#hide();
    const status = await this.#client.control.status(componentRef).catch(() => null);
    if (status === null) this.#hide();
    else if (componentRef === this.#componentRef) this.#changed(status);
  }

  #changed({ state = "FREE", holder = "", position = 0 }: LeaseStatus): void {
    if (this.#watching || (state === "MINE" && this.#asked)) return;
    this.#asked = null;
    if (state === "MINE" && this.#held !== "") return this.#show(this.#held, null, null);
    if (state === "FREE" || state === "MINE") return this.#hide();
    const componentRef = this.#componentRef ?? "";
    const away = state === "ABSENT" ? ", whose connection is lost," : "";
    if (position > 0) {
      const leave: Press = async () => {
        await this.#client.call("openrois.lease.leave", { component_ref: componentRef });
        await this.#look();
      };
      return this.#show(`You wait for control: number ${position} in line`, null, ["Leave", leave]);
    }
    const request: Press = async () => {
      const asking = this.#client.control.request(componentRef, { wait: true });
      await Promise.race([asking, this.#client.control.status(componentRef).then(() => this.#look())]);
      asking.catch(() => undefined);
    };
    this.#show(`${holder}${away} has control`, ["Ask for it", request], null);
  }

  #ask(asked: LeaseRequestedNotification): void {
    if (asked.component_ref !== this.#componentRef) return;
    this.#asked = asked;
    const { request_id: requestId, subject } = asked;
    const answer =
      (grant: boolean): Press =>
      async () => {
        await (grant ? this.#client.control.grant(requestId) : this.#client.control.decline(requestId));
        this.#done(requestId);
      };
    this.#show(`${subject} asks for control`, ["Hand over", answer(true)], ["Keep", answer(false)]);
    clearTimeout(this.#answering);
    this.#answering = setTimeout(() => this.#done(requestId), asked.answer_ms);
  }

  #done(requestId: string): void {
    if (this.#asked?.request_id !== requestId) return;
    this.#asked = null;
    void this.#look();
  }

  #hide(): void {
    this.#bar.hidden = true;
  }

  #show(words: string, yes: readonly [string, Press] | null, no: readonly [string, Press] | null): void {
    // What only tells stands in the page, and what asks above it.
    this.#bar.classList.toggle("telling", yes === null && no === null);
    setText(this.#words, words);
    setText(this.#yes, yes?.[0] ?? "");
    setText(this.#no, no?.[0] ?? "");
    this.#yes.hidden = yes === null;
    this.#no.hidden = no === null;
    this.#press = { yes: yes?.[1] ?? null, no: no?.[1] ?? null };
    this.#bar.hidden = false;
  }
}
