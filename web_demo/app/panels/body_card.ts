/** A body beside the large one: its picture, its floor map, and its control. */

import type { Client } from "../../sdk/index.ts";
import type { MediaReceiver, RemoteStream } from "../../sdk/media/index.ts";
import { byRole, byTestId, setText } from "../dom/elements.ts";
import { MapCard } from "../map/map_card.ts";
import { movingParts } from "../model/bodies.ts";
import type { PageBody } from "../model/bodies.ts";
import { BodyControl } from "../model/body_control.ts";
import type { Rights } from "../model/permission.ts";
import { Control } from "./control.ts";
import { Handover } from "./handover.ts";
import { Stage } from "./stage.ts";

export class BodyCard {
  readonly element: HTMLElement;
  readonly engineId: string;
  readonly #stage: Stage;
  readonly #map: MapCard;
  readonly #body: BodyControl;
  readonly #control: Control;
  readonly #handover: Handover;
  readonly #video: RemoteStream | null;
  #present: PageBody | null = null;
  #watching = "";

  /**
   * @param body the body, which is there now
   * @param isUsed returns whether the visitor has used the page a moment ago
   * @param onEnlarge is called when the visitor wants to see it large
   */
  constructor(
    client: Client,
    receiver: MediaReceiver,
    body: PageBody,
    isUsed: () => boolean,
    onEnlarge: () => void,
  ) {
    this.engineId = body.engineId;
    const template = byRole("body-card", HTMLTemplateElement);
    this.element = byTestId("body-card", HTMLElement, template.content.cloneNode(true) as DocumentFragment);
    this.element.dataset["engine"] = body.engineId;
    setText(byRole("body-name", HTMLElement, this.element), body.engineId);
    byTestId("body-enlarge", HTMLButtonElement, this.element).addEventListener("click", onEnlarge);
    this.#stage = new Stage(this.element);
    this.#body = new BodyControl(client, () => this.#controlChanged(), isUsed);
    this.#control = new Control(client, receiver, this.#body, this.#stage.video, this.element);
    this.#handover = new Handover(this.#body, (giveBack) => this.#control.drive(giveBack), this.element);
    this.#body.onLost = (why) => this.#control.controlLost(why);
    const id = `map-${body.engineId}`;
    const card = byRole("card-map", HTMLElement, this.element);
    card.setAttribute("aria-label", `Floor of ${body.engineId}`);
    this.#map = new MapCard(client, card, id);
    const video = body.video === null ? null : receiver.stream(body.video, "video");
    this.#video = video;
    this.#stage.watch(video);
    byRole("body-picture", HTMLElement, this.element).hidden = video === null;
    void (video?.desire === "suspended" ? video.resume() : video?.connect());
  }

  /** Whether the visitor has control of the body, or waits for it. */
  get isOperated(): boolean {
    const { kind } = this.#body.state;
    return kind === "mine" || kind === "waiting";
  }

  /** The body as it is now; null while it is away. */
  get present(): PageBody | null {
    return this.#present;
  }

  /**
   * @param present the body as it is now; null while it is away
   */
  update(present: PageBody | null, { watching, ranked }: Rights): void {
    this.#present = present;
    this.#watching = watching;
    this.#body.ranked = ranked;
    this.#map.setBody(present);
    this.#control.setComponent(present?.teleoperation ?? null);
    this.#body.setComponents(present && movingParts(present));
    this.#controlChanged();
  }

  /** @param visible whether the card can be seen; hidden, its map asks for nothing */
  render(visible: boolean): void {
    this.#stage.render(this.#present !== null, null);
    this.#map.shown = visible;
    this.#handover.render();
  }

  /** Ends what the card has; the stream goes on where it is shown large from now on. */
  close(keepStream: boolean): void {
    this.update(null, { watching: "", ranked: false });
    this.#map.shown = false;
    if (!keepStream) void this.#video?.disconnect();
    this.element.remove();
  }

  #controlChanged(): void {
    const present = this.#present;
    const why = (ref: string | null): string => {
      const holder = this.#body.holderOf(ref);
      return this.#watching || (holder && `${holder} has control`);
    };
    const operated = present && (movingParts(present)[0] ?? null);
    const { hindrance } = this.#body;
    this.#control.barred = this.#watching || (hindrance && `${hindrance} has control`);
    this.#map.viewBarred = why(operated);
    this.#map.barred = why(present?.navigation ?? null);
    this.#handover.watching = this.#watching !== "";
    this.#handover.shown = present !== null && operated !== null && this.#watching === "";
  }
}
