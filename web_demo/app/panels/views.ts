/** Which view the page shows: the avatar, or the inspector, which is loaded when it is looked at for the first time. */

import type { Client } from "../../sdk/index.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";
import type { Inspector } from "../inspector/inspector.ts";
import { idOf } from "../inspector/routes.ts";
import type { Listing } from "../model/bodies.ts";

export type View = "avatar" | "inspector";

const SKIP: Readonly<Record<View, string>> = {
  avatar: "Skip to the body's controls",
  inspector: "Skip to the search",
};

/** Follows the page's address: `#inspector/<component_ref>` is a component in the inspector. */
export class Views {
  readonly #client: Client;
  readonly #avatar = byRole("view-avatar", HTMLElement);
  readonly #inspector = byRole("view-inspector", HTMLElement);
  readonly #skip = byRole("skip", HTMLAnchorElement);
  readonly #links = {
    avatar: byTestId("show-avatar", HTMLAnchorElement),
    inspector: byTestId("show-inspector", HTMLAnchorElement),
  };
  #current: View = "avatar";
  #since = performance.now();
  #loading: Promise<void> | null = null;
  #loaded: Inspector | null = null;
  #listing: Listing | null = null;
  #connected = false;

  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    addEventListener("hashchange", () => {
      this.#follow();
      onChange();
    });
    this.#skip.addEventListener("click", (event) => {
      event.preventDefault();
      if (this.#current === "inspector") this.search();
      else document.getElementById("say-text")?.focus();
    });
    this.#follow();
  }

  get current(): View {
    return this.#current;
  }

  /** Since when this view is shown, on the clock of `performance.now`. */
  get since(): number {
    return this.#since;
  }

  /** What the inspector shows; it need not be loaded yet. */
  update(listing: Listing | null, connected: boolean): void {
    this.#listing = listing;
    this.#connected = connected;
    this.#loaded?.update(listing, connected);
  }

  /** Goes to the other view. */
  toggle(): void {
    location.hash = this.#current === "avatar" ? "inspector" : "avatar";
  }

  search(): void {
    this.#loaded?.search();
  }

  #follow(): void {
    const id = idOf(location.hash);
    const current = id === null ? "avatar" : "inspector";
    if (current !== this.#current) this.#since = performance.now();
    this.#current = current;
    for (const view of ["avatar", "inspector"] as const) {
      if (view === this.#current) this.#links[view].setAttribute("aria-current", "page");
      else this.#links[view].removeAttribute("aria-current");
    }
    document.body.dataset["view"] = this.#current;
    this.#avatar.hidden = this.#current !== "avatar";
    this.#inspector.hidden = this.#current !== "inspector";
    setText(this.#skip, SKIP[this.#current]);
    document.title = id === null ? "OpenRoIS" : `${id || "Inspector"} · OpenRoIS`;
    if (this.#current === "inspector") this.#loading ??= this.#load();
    this.#loaded?.select(id ?? "");
    if (this.#loaded) this.#loaded.shown = this.#current === "inspector";
  }

  async #load(): Promise<void> {
    try {
      const [{ Inspector }] = await Promise.all([import("../inspector/inspector.ts"), loadStyles()]);
      this.#inspector.replaceChildren();
      this.#loaded = new Inspector(this.#client, this.#inspector);
      this.#loaded.update(this.#listing, this.#connected);
      this.#follow();
    } catch {
      this.#inspector.replaceChildren(
        make(
          "p",
          { class: "hint", role: "alert" },
          "The inspector could not be loaded. Reload the page once the gateway runs.",
        ),
      );
    }
  }
}

/** @throws when the file cannot be had */
function loadStyles(): Promise<unknown> {
  const link = make("link", { rel: "stylesheet", href: "inspector.css" });
  return new Promise((resolve, reject) => {
    link.addEventListener("load", resolve);
    link.addEventListener("error", reject);
    document.head.append(link);
  });
}
