/** From where the pictures show the avatar, to be chosen for all viewers. */

import type { Client, Subscription } from "../../sdk/index.ts";
import { ComponentWatch, isUsable } from "../model/component_status.ts";
import { make } from "../dom/elements.ts";
import { Viewpoint } from "../model/own_components.ts";
import { explain } from "../model/permission.ts";

/** Of the engines that come with the avatar; others name theirs as they like. */
const WORDS: Readonly<Record<string, string>> = {
  automatic: "Automatic",
  face: "Face",
  room: "Room",
  follow: "Follow",
  eyes: "Its own eyes",
};

export class ViewpointChoice {
  readonly #client: Client;
  readonly #select = make("select", { "data-testid": "viewpoint" });
  readonly element = make("label", { class: "viewpoint", hidden: "" }, "Camera", this.#select);
  readonly #watch: ComponentWatch;
  #viewpoint: Viewpoint | null = null;
  #changes: Promise<Subscription> | null = null;

  constructor(client: Client) {
    this.#client = client;
    this.#watch = new ComponentWatch(client, (status) => {
      if (!isUsable(status)) this.element.hidden = true;
      return isUsable(status) ? this.#read() : undefined;
    });
    this.#select.addEventListener("change", () => void this.#choose());
  }

  /** @param componentRef null where there is none, or it is away */
  setComponent(componentRef: string | null): void {
    if (componentRef !== (this.#viewpoint?.componentRef ?? null)) {
      void this.#changes?.then((subscription) => subscription.cancel()).catch(() => undefined);
      this.#changes = null;
      this.#viewpoint = componentRef === null ? null : new Viewpoint(this.#client, componentRef);
    }
    this.#watch.watch(componentRef);
  }

  /** Why none can be chosen now; empty where one can. */
  set barred(barred: string) {
    this.#select.disabled = barred !== "";
    explain(this.#select, barred);
  }

  async #read(): Promise<void> {
    const viewpoint = this.#viewpoint;
    if (!viewpoint) return;
    this.#changes ??= viewpoint.changed.subscribe(({ viewpoint: name }) => (this.#select.value = name));
    const heard = await this.#changes.then(
      () => null,
      (error: Error) => {
        this.#changes = null;
        return error;
      },
    );
    try {
      const { available_viewpoints: names } = await viewpoint.available();
      const { viewpoint: current } = await viewpoint.current();
      if (viewpoint !== this.#viewpoint) return;
      this.#select.replaceChildren(
        ...names.map((name) => make("option", { value: name }, WORDS[name] ?? name)),
      );
      this.#select.value = current;
      this.element.hidden = names.length < 2;
    } catch (error) {
      this.element.hidden = true;
      throw error;
    }
    // The choice is there all the same; the subscription for the choices of others is tried again.
    if (heard) throw heard;
  }

  async #choose(): Promise<void> {
    try {
      await this.#viewpoint?.choose(this.#select.value);
    } catch {
      // Shows what holds, now or as soon as that can be asked.
      this.#watch.watch(this.#viewpoint?.componentRef ?? null);
    }
  }
}
