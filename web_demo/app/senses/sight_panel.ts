/** Preview of the camera, with the faces that the avatar sees in it. */

import type { Client } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { describeFailure } from "../model/outcome.ts";
import { sentence } from "../model/plain_words.ts";
import { Enrolment, Sight } from "../model/own_components.ts";
import { Faces, inMirror } from "./boxes.ts";
import type { Box, Face } from "./boxes.ts";
import { Switch } from "./switch.ts";
import { Wanted } from "./wanted.ts";
import { isOwn } from "../model/consent.ts";

/** Milliseconds after which faces without a new event are removed. */
const FRESH = 1500;
/** Milliseconds for which it stands why something failed. */
const READABLE = 4000;
const BUSY = "Another visitor uses it now";
const KEPT =
  "A face is kept in the memory of the body's adapter and nowhere else, and is gone when that ends.";

export class SightPanel {
  /** The visitor that this page is; empty while that is not known. */
  visitorRef = "";
  readonly element = make("div", { class: "sense" });
  readonly #client: Client;
  readonly #onChange: () => void;
  readonly #preview = make("video", { class: "preview", "data-testid": "preview" });
  readonly #boxes = make("div", { class: "boxes", "aria-hidden": "true" });
  readonly #switch: Switch;
  readonly #seen = new Wanted((error) => this.#refused(error));
  readonly #form: HTMLFormElement;
  readonly #name = make("input", {
    type: "text",
    maxlength: "64",
    placeholder: "Your name",
    "aria-label": "Name to remember your face by",
    "data-testid": "enrol-name",
    autocomplete: "off",
  });
  readonly #known = make("ul", { class: "known", "aria-label": "Remembered faces" });
  readonly #words = make("p", { class: "sense-words", "data-testid": "sight-words", "aria-live": "polite" });
  readonly #faces = new Faces();
  readonly #drawn = new Map<string, HTMLElement>();
  #sight: Sight | null = null;
  #enrolment: Enrolment | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;

  /** @param onChange is called when it begins to look, or ends */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    this.#preview.muted = true;
    this.#preview.autoplay = true;
    this.#preview.playsInline = true;
    this.#preview.setAttribute("aria-label", "What your camera shows");
    this.#switch = new Switch("sight-switch", "Let it look for faces", () => this.#update());
    const remember = make("button", { class: "button small", "data-testid": "enrol" }, "Remember me");
    this.#form = make("form", { class: "enrol" }, this.#name, remember);
    this.#form.append(make("p", { class: "hint" }, KEPT), this.#known);
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#enrol(this.#name.value.trim());
    });
    const picture = make("div", { class: "picture" }, this.#preview, this.#boxes);
    this.element.append(picture, this.#switch.element, this.#words, this.#form);
    this.#update();
  }

  /** Whether the avatar looks at the camera for this page. */
  get looks(): boolean {
    return this.#seen.wanted;
  }

  /** @param sight,enrolment refs of components; null where there are none */
  setComponents(sight: string | null, enrolment: string | null): void {
    if (sight !== (this.#sight?.componentRef ?? null)) {
      const component = sight === null ? null : new Sight(this.#client, sight);
      this.#sight = component;
      this.#seen.from(
        component &&
          (() =>
            component.seen.subscribe((seen) => {
              if (isOwn(seen, this.visitorRef)) this.#show(this.#faces.see(seen, performance.now()));
            })),
      );
    }
    if (enrolment !== (this.#enrolment?.componentRef ?? null))
      this.#enrolment = enrolment === null ? null : new Enrolment(this.#client, enrolment);
    this.#update();
  }

  /** @param track of the camera; null while it is off */
  show(track: MediaStreamTrack | null): void {
    const shown = this.#preview.srcObject instanceof MediaStream ? this.#preview.srcObject : null;
    if (track === (shown?.getTracks()[0] ?? null)) return;
    this.#preview.srcObject = track && new MediaStream([track]);
    this.#update();
  }

  #update(): void {
    const on = this.#switch.on && this.#sight !== null;
    const wanted = on && this.#preview.srcObject !== null;
    const began = wanted && !this.#seen.wanted;
    this.#seen.wanted = wanted;
    this.#switch.element.hidden = this.#sight === null;
    this.#form.hidden = !on || this.#enrolment === null;
    if (!wanted) this.#show([]);
    if (began) {
      this.#say("No person in view yet");
      void this.#list();
    }
    this.#words.hidden = !on;
    this.#onChange();
  }

  #show(faces: readonly Face[]): void {
    clearTimeout(this.#fading);
    if (faces.length > 0) this.#fading = setTimeout(() => this.#show([]), FRESH);
    const { videoWidth, videoHeight, clientWidth, clientHeight } = this.#preview;
    const [picture, preview] = [videoWidth / videoHeight || 1, clientWidth / clientHeight || 1];
    const refs = new Set(faces.map(({ ref }) => ref));
    for (const [ref, box] of this.#drawn) {
      if (refs.has(ref)) continue;
      box.remove();
      this.#drawn.delete(ref);
    }
    for (const face of faces) this.#draw(face, inMirror(face.box, picture, preview));
    if (this.#seen.wanted && this.#form.dataset["busy"] === undefined) this.#say(peopleWords(faces));
  }

  /** A face that is drawn already moves to where it is now. */
  #draw({ ref, name, gesture }: Face, place: Box): void {
    const box = this.#drawn.get(ref) ?? make("div", { "data-testid": "face" }, make("span"));
    box.className = name === "" ? "box" : "box known";
    if (box.firstElementChild) setText(box.firstElementChild, [name || "A person", gesture].join(" ").trim());
    for (const [side, share] of Object.entries(place))
      box.style.setProperty(side, `${(100 * share).toFixed(2)}%`);
    if (this.#drawn.has(ref)) return;
    this.#drawn.set(ref, box);
    this.#boxes.append(box);
  }

  async #enrol(name: string): Promise<void> {
    if (name === "") return this.#name.focus();
    const done = await this.#change(`Looking at ${name} …`, (enrolment) => enrolment.enrol(name));
    if (done) this.#name.value = "";
  }

  async #list(): Promise<void> {
    const names = (await this.#enrolment?.enrolled().catch(() => null))?.names ?? [];
    this.#known.replaceChildren(
      ...names.map((name) => {
        const forget = make("button", { type: "button", class: "forget", title: `Forget ${name}` }, name);
        forget.append(make("span", { "aria-hidden": "true" }, "×"));
        forget.setAttribute("aria-label", `Forget ${name}`);
        forget.addEventListener("click", () => void this.#change("", (enrolment) => enrolment.forget(name)));
        return make("li", {}, forget);
      }),
    );
  }

  /** Returns whether it was done. */
  async #change(doing: string, change: (enrolment: Enrolment) => Promise<void>): Promise<boolean> {
    if (!this.#enrolment || this.#form.dataset["busy"] !== undefined) return false;
    this.#form.dataset["busy"] = "";
    this.#say(doing);
    try {
      await change(this.#enrolment);
      this.#say("");
      return true;
    } catch (error) {
      this.#refused(error);
      // Long enough to be read before the persons in view are shown again.
      await new Promise((resolve) => setTimeout(resolve, READABLE));
      return false;
    } finally {
      delete this.#form.dataset["busy"];
      await this.#list();
    }
  }

  #refused(error: unknown): void {
    this.#say(sentence(describeFailure(error, BUSY).text), true);
  }

  #say(words: string, failed = false): void {
    setText(this.#words, words);
    this.#words.classList.toggle("failed", failed);
  }
}

function peopleWords(faces: readonly Face[]): string {
  if (faces.length === 0) return "No person in view";
  const strangers = faces.filter(({ name }) => name === "").length;
  const names = faces.flatMap(({ name }) => (name === "" ? [] : name));
  const others = strangers === 0 ? [] : [strangers === 1 ? "a person" : `${strangers} people`];
  return `It sees ${[...names, ...others].join(" and ")}`;
}
