/** The floor map: where the avatar is and what is around it; a click sends it there. */

import { SystemInformation } from "../../sdk/index.ts";
import type { Client, Subscription } from "../../sdk/index.ts";
import type { PageBody } from "../model/bodies.ts";
import { ComponentWatch, isUsable } from "../model/component_status.ts";
import { icon, make, setText } from "../dom/elements.ts";
import { Surroundings } from "../model/own_components.ts";
import { FloorView } from "./floor_view.ts";
import type { Ground } from "./floor_view.ts";
import {
  HOME,
  findDock,
  isAway,
  moved,
  nearest,
  pointWords,
  positionText,
  readCorners,
  readPlace,
  readThings,
} from "./geometry.ts";
import type { Place, Point, Thing } from "./geometry.ts";
import { ViewpointChoice } from "./viewpoint_choice.ts";
import { Walk } from "./walk.ts";

/** The least milliseconds between two questions for the things. */
const PACE = 400;
/** Metres from a thing within which a click means it. */
const REACH = 0.35;
const HINT = "Click where it should go. With Shift it goes there afterwards.";
const NO_WALK = "This body does not walk.";
const NO_FLOOR = "The floor is not known: it walks straight to where you click.";
const NOWHERE: Ground = { outline: [], obstacles: [] };

export class MapCard {
  readonly #client: Client;
  readonly #element: HTMLElement;
  readonly #view = new FloorView();
  readonly #walk: Walk;
  readonly #viewpoint: ViewpointChoice;
  readonly #watch: ComponentWatch;
  readonly #scene: ComponentWatch;
  readonly #words = make("p", { class: "map-words", "data-testid": "map-words", "aria-live": "polite" });
  readonly #choice = make("div", { class: "map-choice", "data-testid": "map-choice" });
  readonly #stop = make(
    "button",
    { type: "button", class: "button small", "data-testid": "map-stop" },
    "Stop",
  );
  readonly #back = make(
    "button",
    { type: "button", class: "button small", "data-testid": "map-back", hidden: "" },
    "Come back",
  );
  readonly #open: HTMLButtonElement;
  readonly #body: HTMLElement;
  #shownBody: PageBody | null = null;
  #surroundings: Surroundings | null = null;
  #shown = false;
  #following: Promise<Subscription>[] = [];
  #asked: ReturnType<typeof setTimeout> | undefined;
  #ground = NOWHERE;
  #things: readonly Thing[] = [];
  #figure: Place | null = null;
  #cursor: Point | null = null;
  /** Null while that is not known. */
  #walks: boolean | null = null;
  #barred = "";

  /**
   * @param element the card
   * @param id begins the ids of its parts; unique in the page
   */
  constructor(client: Client, element: HTMLElement, id: string) {
    this.#client = client;
    this.#element = element;
    this.#body = make("div", { class: "map-body", id: `${id}-body` });
    this.#walk = new Walk(client, () => this.#render());
    this.#viewpoint = new ViewpointChoice(client);
    this.#watch = new ComponentWatch(client, (status) => {
      this.#walks = status === null ? null : isUsable(status);
      this.#render();
    });
    this.#scene = new ComponentWatch(client, (status) => {
      if (isUsable(status) && this.#surroundings) this.#follow(this.#surroundings);
    });
    this.#open = make(
      "button",
      {
        type: "button",
        class: "disclosure",
        "data-testid": "map-open",
        "aria-expanded": "true",
        "aria-controls": this.#body.id,
      },
      icon("M4 6.500l5-2 6 2 5-2v13l-5 2-6-2-5 2ZM9 4.500v13M15 6.500v13"),
      "Floor",
      icon("M8 10l4 4 4-4"),
    );
    const title = make("h2", { id: `${id}-title` }, this.#open);
    this.#body.append(this.#view.element, this.#choice, this.#words, this.#viewpoint.element);
    this.#element.append(make("header", {}, title, this.#back, this.#stop), this.#body);
    this.#open.addEventListener("click", () => {
      this.#body.hidden = !this.#body.hidden;
      this.#open.setAttribute("aria-expanded", String(!this.#body.hidden));
      this.#update();
    });
    this.#stop.addEventListener("click", () => this.#walk.stop());
    this.#back.addEventListener("click", () => {
      const { x, y, th } = HOME;
      const front = { text: `${x},${y},${th.toFixed(4)}`, words: "the front", place: HOME };
      const dock = findDock(this.#things);
      this.#walk.go(dock ? { text: dock.ref, words: "the dock", place: dock.place } : front, false);
    });
    this.#listen();
    this.#render();
  }

  /** @param body what is there now; null while it is away */
  setBody(body: PageBody | null): void {
    if (body !== null) this.#element.hidden = body.surroundings === null;
    const ref = body?.surroundings ?? null;
    this.#shownBody = body;
    if (body) this.#walk.setComponents(body.navigation, body.follow);
    if (ref !== (this.#surroundings?.componentRef ?? null)) {
      this.#unfollow();
      this.#surroundings = ref === null ? null : new Surroundings(this.#client, ref);
    }
    this.#update();
  }

  /** Why the viewpoint cannot be chosen now; empty where it can. */
  set viewBarred(barred: string) {
    this.#viewpoint.barred = barred;
  }

  /** Why the avatar cannot be sent anywhere now; empty where it can. */
  set barred(barred: string) {
    if (barred === this.#barred) return;
    this.#barred = barred;
    if (barred !== "") this.#choice.replaceChildren();
    this.#render();
  }

  /** Whether the card can be seen; hidden, it asks for nothing. */
  set shown(shown: boolean) {
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#update();
  }

  /** Begins to follow what happens on the floor as soon as there is a scene, or ends that. */
  #update(): void {
    const surroundings = this.#shown && !this.#body.hidden ? this.#surroundings : null;
    this.#scene.watch(surroundings?.componentRef ?? null);
    this.#watch.watch(surroundings && (this.#shownBody?.navigation ?? null));
    this.#viewpoint.setComponent(surroundings && (this.#shownBody?.viewpoint ?? null));
    if (surroundings === null) this.#unfollow();
  }

  #follow(surroundings: Surroundings): void {
    // It may have been away meanwhile; what is subscribed to has come back by itself.
    void this.#askAll(surroundings);
    if (this.#following.length > 0) return;
    const following = [
      surroundings.figureMoved.subscribe(({ position_data: text }) => this.#moved(readPlace(text))),
      surroundings.floorChanged.subscribe(() => void this.#askFloor(surroundings)),
      surroundings.thingsChanged.subscribe(() => this.#askSoon(surroundings)),
    ];
    this.#following = following;
    Promise.all(following).catch(() => {
      // The scene is gone again: the next answer begins anew.
      if (this.#following === following) this.#update();
    });
  }

  #unfollow(): void {
    clearTimeout(this.#asked);
    this.#asked = undefined;
    for (const each of this.#following.splice(0))
      void each.then((subscription) => subscription.cancel()).catch(() => undefined);
  }

  async #askAll(surroundings: Surroundings): Promise<void> {
    const system = this.#shownBody?.system ?? null;
    const where = system === null ? null : new SystemInformation(this.#client, system).robotPosition();
    await Promise.all([
      this.#askFloor(surroundings),
      this.#askThings(surroundings),
      where?.then(({ position_data: [text = ""] }) => this.#moved(readPlace(text))).catch(() => undefined),
    ]);
  }

  async #askFloor(surroundings: Surroundings): Promise<void> {
    const floor = await surroundings.floor().catch(() => null);
    if (floor === null || surroundings !== this.#surroundings) return;
    const { outline, obstacles } = floor;
    this.#ground = { outline: readCorners(outline), obstacles: obstacles.map(readCorners) };
    this.#render();
    this.#drawGround();
  }

  /** Asks for the things later: each of their steps causes an event. */
  #askSoon(surroundings: Surroundings): void {
    this.#asked ??= setTimeout(() => {
      this.#asked = undefined;
      void this.#askThings(surroundings);
    }, PACE);
  }

  async #askThings(surroundings: Surroundings): Promise<void> {
    const things = await surroundings.things().catch(() => null);
    if (things === null || surroundings !== this.#surroundings) return;
    this.#things = readThings(things);
    this.#view.showThings(this.#things);
    this.#renderBack();
    if (this.#ground.outline.length === 0) this.#drawGround();
  }

  #moved(place: Place | null): void {
    const first = this.#figure === null;
    this.#figure = place;
    this.#view.showFigure(place);
    this.#renderBack();
    this.#view.showWay(place, this.#walk.targets);
    if (first && this.#ground.outline.length === 0) this.#drawGround();
  }

  #drawGround(): void {
    const all = [
      { x: 0, y: 0 },
      ...this.#things.map(({ place }) => place),
      ...(this.#figure ? [this.#figure] : []),
    ];
    this.#view.showGround(
      this.#ground,
      all.map(({ x, y }) => [x, y]),
    );
  }

  #listen(): void {
    const { element } = this.#view;
    element.addEventListener("click", ({ clientX, clientY, shiftKey }) => {
      const point = this.#view.at(clientX, clientY);
      this.#point(null);
      if (point) this.#choose(point, shiftKey);
    });
    element.addEventListener("keydown", (event) => {
      const from =
        this.#cursor ?? (this.#figure ? ([this.#figure.x, this.#figure.y] as const) : ([0, 0] as const));
      const point = moved(from, event.key, event.shiftKey, this.#view.extent);
      if (point) this.#point(point);
      else if (event.key === "Enter" && this.#cursor) this.#choose(this.#cursor, event.shiftKey);
      else if (event.key === "Escape") this.#point(null);
      else return;
      event.preventDefault();
      if (event.key !== "Escape") event.stopPropagation();
    });
    element.addEventListener("blur", () => this.#point(null));
  }

  #point(at: Point | null): void {
    this.#cursor = at;
    this.#view.showCursor(at);
  }

  /** Sends the avatar to a place; for a person the visitor chooses between going and following. */
  #choose(point: Point, further: boolean): void {
    this.#choice.replaceChildren();
    if (this.#walks !== true || this.#barred !== "") return;
    const thing = nearest(this.#things, point, REACH);
    if (thing === null || further)
      return this.#walk.go(
        { text: positionText(point), words: pointWords(point), place: { x: point[0], y: point[1] } },
        further,
      );
    const option = (words: string, name: string, run: () => void): HTMLButtonElement => {
      const button = make("button", { type: "button", class: "button small", "data-testid": name }, words);
      button.addEventListener("click", () => {
        this.#choice.replaceChildren();
        this.#view.element.focus({ preventScroll: true });
        run();
      });
      return button;
    };
    const { ref, name, place, kind } = thing;
    const go = option("Go there", "map-go", () => this.#walk.go({ text: ref, words: name, place }, false));
    const follow = option("Follow", "map-follow", () => this.#walk.follow(thing));
    const options = kind === "person" && this.#walk.canFollow ? [follow, go] : [go];
    this.#choice.append(make("span", {}, name), ...options);
    options[0]?.focus({ preventScroll: true });
  }

  /** Shows the button while the avatar is away and stands still. */
  #renderBack(): void {
    const dock = findDock(this.#things);
    const away = this.#figure !== null && isAway(this.#figure, dock);
    setText(this.#back, dock ? "To the dock" : "Come back");
    this.#back.hidden = !away || this.#walks !== true || !this.#stop.hidden;
  }

  #render(): void {
    const { state, words, targets, followed } = this.#walk;
    const hint = this.#walks === false ? NO_WALK : this.#ground.outline.length === 0 ? NO_FLOOR : HINT;
    const usable = this.#walks === true && this.#barred === "";
    const idle = this.#walks === true && this.#barred !== "" ? `${this.#barred}.` : hint;
    setText(this.#words, this.#walks === null ? "" : state === "idle" || !usable ? idle : words);
    this.#words.dataset["state"] = usable ? state : "idle";
    this.#view.element.classList.toggle("walks", usable);
    if (usable) this.#view.element.removeAttribute("aria-disabled");
    else this.#view.element.setAttribute("aria-disabled", "true");
    this.#stop.hidden = state !== "walking";
    this.#renderBack();
    this.#view.showWay(this.#figure, targets);
    this.#element.dataset["followed"] = followed?.ref ?? "";
  }
}
