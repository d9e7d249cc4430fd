/** Card of one stream: its status in RoIS, and the four verbs. */

import type { MediaKind } from "../../sdk/index.ts";
import type { RemoteStream } from "../../sdk/media/index.ts";
import { byRole, icon, make, setText } from "../dom/elements.ts";
import { codeWords } from "../model/code_words.ts";
import { sentence } from "../model/plain_words.ts";

const ICONS: Readonly<Record<MediaKind, string>> = {
  video:
    "M4.5 6.500h9A1.500 1.500 0 0 1 15 8v8a1.500 1.500 0 0 1-1.500 1.500h-9A1.500 1.500 0 0 1 3 16V8a1.500 1.500 0 0 1 1.500-1.500ZM15 10.500l6-3v9l-6-3",
  audio: "M4 10v4M8 6.500v11M12 9v6M16 4.500v15M20 10v4",
};

const TITLES: Readonly<Record<MediaKind, string>> = { video: "Video", audio: "Audio" };

export class StreamCard {
  readonly #kind: MediaKind;
  readonly #element: HTMLElement;
  readonly #status: HTMLElement;
  readonly #buttons: Record<"suspend" | "resume" | "disconnect" | "connect", HTMLButtonElement>;
  #stream: RemoteStream | null = null;
  #present = false;
  #stopListening: (() => void) | null = null;

  constructor(kind: MediaKind) {
    this.#kind = kind;
    this.#element = byRole(`card-${kind}`, HTMLElement);
    this.#status = make("span", { class: "stream-status", role: "status", "data-testid": `status-${kind}` });
    this.#buttons = {
      suspend: this.#button("suspend", "Suspend"),
      resume: this.#button("resume", "Resume"),
      disconnect: this.#button("disconnect", "Disconnect"),
      connect: this.#button("connect", "Connect"),
    };
    const title = make("h2", { id: `${kind}-title` }, icon(ICONS[kind]), TITLES[kind]);
    const { suspend, resume, disconnect, connect } = this.#buttons;
    const verbs = make("div", { class: "verbs" }, suspend, resume, disconnect, connect);
    this.#element.append(make("header", {}, title, this.#status), verbs);
    this.watch(null);
  }

  /** Shows another stream; null when the avatar has none of this kind. */
  watch(stream: RemoteStream | null): void {
    this.#stopListening?.();
    this.#stream = stream;
    this.#stopListening = stream?.on("change", () => this.#render()) ?? null;
    this.#render();
  }

  /** Whether the avatar is there: while it is away nothing can be asked of its streams. */
  set present(present: boolean) {
    if (present === this.#present) return;
    this.#present = present;
    this.#render();
  }

  #button(verb: "suspend" | "resume" | "disconnect" | "connect", label: string): HTMLButtonElement {
    const attributes = { type: "button", class: "button", "data-testid": `${this.#kind}-${verb}` };
    const button = make(
      "button",
      attributes,
      label,
      make("span", { class: "visually-hidden" }, ` ${this.#kind}`),
    );
    button.addEventListener("click", () => void this.#stream?.[verb]());
    return button;
  }

  #render(): void {
    const stream = this.#stream;
    const { suspend, resume, disconnect, connect } = this.#buttons;
    setText(this.#status, stream?.status ? sentence(codeWords(stream.status)) : "–");
    this.#status.dataset["status"] = stream?.status ?? "";
    this.#element.classList.toggle("busy", stream?.busy ?? false);
    const connected = stream !== null && stream.desire !== "disconnected";
    const suspended = stream?.desire === "suspended" || stream?.status === "STREAMING_SUSPENDED";
    this.#swap(suspended, resume, suspend);
    this.#swap(connected, disconnect, connect);
    suspend.disabled = resume.disabled = !connected || !this.#present;
    disconnect.disabled = connect.disabled = stream === null || !this.#present;
  }

  /** Shows one button of two, and leaves the keyboard's focus where it was. */
  #swap(first: boolean, one: HTMLButtonElement, other: HTMLButtonElement): void {
    const [shown, hidden] = first ? [one, other] : [other, one];
    const focused = document.activeElement === hidden;
    shown.hidden = false;
    hidden.hidden = true;
    if (focused) shown.focus();
  }
}
