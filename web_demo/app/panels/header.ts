/** The bar at the top: which body, whether connected, light or dark. */

import type { ConnectionState } from "../../sdk/index.ts";
import type { BodyDirectory, PageBody } from "../model/bodies.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";

export class Header {
  readonly #directory: BodyDirectory;
  readonly #offered: () => readonly PageBody[];
  readonly #select = byTestId("avatar-select", HTMLSelectElement);
  readonly #name = byRole("avatar-name", HTMLElement);
  readonly #connection = byTestId("connection", HTMLElement);
  readonly #connectionText = byRole("connection-text", HTMLElement);
  #options = "";

  /** @param offered returns the bodies that the visitor may choose from */
  constructor(directory: BodyDirectory, offered: () => readonly PageBody[]) {
    this.#directory = directory;
    this.#offered = offered;
    this.#select.addEventListener("change", () => directory.choose(this.#select.value));
    installThemeToggle();
  }

  render(connection: ConnectionState): void {
    this.#connection.dataset["state"] = connection.name;
    setText(this.#connectionText, connectionWords(connection));
    const chosen = this.#directory.chosen?.engineId ?? "";
    const offered = this.#offered().map(({ engineId }) => engineId);
    const ids = [...new Set([...offered, chosen])].filter((id) => id !== "");
    if (ids.join() !== this.#options) {
      this.#options = ids.join();
      this.#select.replaceChildren(...ids.map((id) => make("option", { value: id }, id)));
    }
    this.#select.value = chosen;
    this.#select.hidden = ids.length < 2;
    this.#name.hidden = !this.#select.hidden;
    setText(this.#name, chosen);
  }
}

function connectionWords(connection: ConnectionState): string {
  switch (connection.name) {
    case "connected":
      return "Connected";
    case "connecting":
      return "Connecting";
    case "waiting":
      return "Offline";
    case "closed":
      return "Closed";
  }
}

function installThemeToggle(): void {
  const button = byTestId("theme-toggle", HTMLButtonElement);
  const system = matchMedia("(prefers-color-scheme: dark)");
  const { dataset } = document.documentElement;
  const isDark = (): boolean => (dataset["theme"] ?? (system.matches ? "dark" : "light")) === "dark";
  const render = (): void => button.setAttribute("aria-pressed", String(isDark()));
  button.addEventListener("click", () => {
    dataset["theme"] = isDark() ? "light" : "dark";
    localStorage.setItem("openrois.theme", dataset["theme"]);
    render();
  });
  system.addEventListener("change", render);
  render();
}
