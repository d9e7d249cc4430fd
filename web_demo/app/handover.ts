/** Who has control of the avatar: one may ask for it, and whoever has it is asked. */

import type { Client, LeaseRequestedNotification, LeaseStatus } from "../sdk/index.ts";
import { byRole, byTestId, setText } from "./dom.ts";
import { WATCHING } from "./permission.ts";

type Press = () => Promise<unknown>;
type Choice = readonly [words: string, press: Press];

/** What a gateway without authentication calls everybody. */
const ANYBODY = "local";

/** Somebody who waits for an answer, until the time for it is over. */
interface Asking {
  readonly told: LeaseRequestedNotification;
  readonly ending: ReturnType<typeof setTimeout>;
}

export class Handover {
  readonly #client: Client;
  readonly #bar = byTestId("handover", HTMLElement);
  readonly #words = byRole("handover-words", HTMLElement);
  readonly #yes = byTestId("handover-yes", HTMLButtonElement);
  readonly #no = byTestId("handover-no", HTMLButtonElement);
  #componentRef: string | null = null;
  /** Who asks for what this page has, by the request's id, the first one first. */
  readonly #asking = new Map<string, Asking>();
  /** The component that this page has asked for, and neither given back nor ceased to wait for; empty for none. */
  #wanted = "";
  /** The holder said no, or nothing in time; one waits in line all the same. */
  #declined = false;
  #held = "";
  #watching = false;
  #press: { readonly yes: Press | null; readonly no: Press | null } = { yes: null, no: null };

  constructor(client: Client) {
    this.#client = client;
    this.#yes.addEventListener("click", (event) => this.#pressed(event, this.#press.yes));
    this.#no.addEventListener("click", (event) => this.#pressed(event, this.#press.no));
    client.control.on("openrois.lease.requested", (told) => this.#ask(told));
    client.control.on("openrois.lease.withdrawn", ({ request_id }) => this.#done(request_id));
    client.control.on("openrois.lease.declined", ({ component_ref }) => {
      if (component_ref !== this.#componentRef) return;
      this.#declined = true;
      void this.#look();
    });
    client.control.on("openrois.lease.changed", (told) => {
      if (told.component_ref === this.#componentRef) this.#changed(told);
    });
  }

  /** @param componentRef whoever holds this component drives; null while the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    if (componentRef === this.#componentRef) return;
    this.#componentRef = componentRef;
    this.#forget();
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

  /** The second press of a double click was not meant for what stands there after the first. */
  #pressed({ detail }: MouseEvent, press: Press | null): void {
    if (detail < 2) void press?.().catch(() => this.#look());
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
    if (this.#watching) return;
    if (state === "MINE") return this.#has();
    this.#forget();
    if (position === 0) {
      this.#wanted = "";
      this.#declined = false;
    }
    if (state === "FREE") return this.#hide();
    const who = named(holder);
    if (position > 0) return this.#waits(who, position);
    const away = state === "ABSENT" ? ", whose connection is lost," : "";
    this.#show(`${who}${away} has control`, ["Ask for it", () => this.#request()], null);
  }

  #has(): void {
    const [first] = this.#asking.values();
    if (first) return this.#answer(first.told);
    if (this.#held !== "") return this.#show(this.#held, null, null);
    if (this.#wanted !== this.#componentRef) return this.#hide();
    const giveBack: Press = async () => {
      this.#wanted = "";
      await this.#client.release(this.#componentRef ?? "");
      await this.#look();
    };
    this.#show("You have control", null, ["Give back", giveBack]);
  }

  #waits(who: string, position: number): void {
    const leave: Press = async () => {
      this.#wanted = "";
      await this.#client.control.leave(this.#componentRef ?? "");
      await this.#look();
    };
    const line = `number ${position} in line`;
    if (!this.#declined) return this.#show(`You wait for control: ${line}`, null, ["Leave", leave]);
    const again: Choice = ["Ask again", () => this.#request()];
    this.#show(`${who} does not hand over control now. You wait: ${line}`, again, ["Leave", leave]);
  }

  async #request(): Promise<void> {
    const componentRef = this.#componentRef ?? "";
    this.#wanted = componentRef;
    this.#declined = false;
    const asking = this.#client.control.request(componentRef, { wait: true });
    asking.catch(() => this.#look());
    // What is asked next is answered next: who waits has its place by then.
    await this.#look();
  }

  #ask(told: LeaseRequestedNotification): void {
    if (told.component_ref !== this.#componentRef) return;
    const { request_id: requestId, answer_ms: milliseconds } = told;
    clearTimeout(this.#asking.get(requestId)?.ending);
    this.#asking.set(requestId, { told, ending: setTimeout(() => this.#done(requestId), milliseconds) });
    this.#has();
  }

  #answer({ request_id: requestId, subject }: LeaseRequestedNotification): void {
    const answer = (words: string, grant: boolean): Choice => [
      words,
      async () => {
        await (grant ? this.#client.control.grant(requestId) : this.#client.control.decline(requestId));
        this.#done(requestId);
      },
    ];
    const more = this.#asking.size > 1 ? `, and ${this.#asking.size - 1} more` : "";
    this.#show(`${named(subject)} asks for control${more}`, answer("Hand over", true), answer("Keep", false));
  }

  #done(requestId: string): void {
    clearTimeout(this.#asking.get(requestId)?.ending);
    if (this.#asking.delete(requestId)) void this.#look();
  }

  /** Nobody is to be answered any more. */
  #forget(): void {
    for (const { ending } of this.#asking.values()) clearTimeout(ending);
    this.#asking.clear();
  }

  #hide(): void {
    this.#bar.hidden = true;
  }

  #show(words: string, yes: Choice | null, no: Choice | null): void {
    // How things stand is part of the page; who asks must be seen wherever it is scrolled to.
    this.#bar.classList.toggle("asking", this.#asking.size > 0);
    setText(this.#words, words);
    setText(this.#yes, yes?.[0] ?? "");
    setText(this.#no, no?.[0] ?? "");
    this.#yes.hidden = yes === null;
    this.#no.hidden = no === null;
    this.#press = { yes: yes?.[1] ?? null, no: no?.[1] ?? null };
    this.#bar.hidden = false;
  }
}

function named(subject: string): string {
  return subject === "" || subject === ANYBODY ? "Somebody else" : subject;
}
