/** The person at this machine: microphone and camera on their way to the avatar, and what arrives there. */

import type { Client, Subscription } from "../sdk/index.ts";
import type { LocalStream, MediaReceiver } from "../sdk/media/index.ts";
import type { Avatar } from "./avatars.ts";
import { SILENCE } from "./decibels.ts";
import { DeviceControl } from "./device_control.ts";
import { byRole, make } from "./dom.ts";
import { LevelBar, TrackLevel } from "./level_bar.ts";
import { Operator } from "./own_components.ts";

export class OperatorCard {
  readonly #client: Client;
  readonly #receiver: MediaReceiver;
  readonly #element = byRole("card-operator", HTMLElement);
  readonly #here = new LevelBar("here", "Here");
  readonly #there = new LevelBar("there", "At the avatar");
  readonly #preview = make("video", { class: "preview", "data-testid": "preview" });
  readonly #microphone: DeviceControl;
  readonly #camera: DeviceControl;
  readonly #local = new TrackLevel((level) => this.#here.show(level));
  /** Components that have said that they take what is sent. */
  readonly #taking = new Set<string>();
  #operator: Operator | null = null;
  #hearing: Promise<Subscription> | null = null;

  constructor(client: Client, receiver: MediaReceiver) {
    this.#client = client;
    this.#receiver = receiver;
    const levels = make("div", { class: "levels" }, this.#here.element, this.#there.element);
    this.#preview.muted = true;
    this.#preview.autoplay = true;
    this.#preview.playsInline = true;
    this.#preview.setAttribute("aria-label", "What your camera shows");
    this.#microphone = new DeviceControl("audio", levels, (track) => {
      this.#local.follow(track);
      this.#hear(track !== null);
    });
    this.#camera = new DeviceControl("video", this.#preview, (track) => this.#show(track));
    this.#element.append(
      make("h2", { id: "operator-title" }, "You"),
      make("div", { class: "devices" }, this.#microphone.element, this.#camera.element),
    );
  }

  /** The streams to the avatar, for the browser's console; null where it takes none. */
  async watch({
    video,
    audio,
    operator,
  }: Avatar): Promise<{ microphone: LocalStream | null; camera: LocalStream | null }> {
    await Promise.all([this.#ask(audio), this.#ask(video)]);
    this.#operator = operator === null ? null : new Operator(this.#client, operator);
    this.#there.element.hidden = operator === null;
    const microphone =
      audio !== null && this.#taking.has(audio) ? this.#receiver.sending(audio, "audio") : null;
    const limits = { width: 640, height: 360, fps: 30, max_bitrate: 1_000_000 };
    const camera = this.#taking.has(video) ? this.#receiver.sending(video, "video", { limits }) : null;
    this.#microphone.watch(microphone);
    this.#camera.watch(camera);
    this.#element.hidden = microphone === null && camera === null;
    this.#microphone.element.hidden = microphone === null;
    this.#camera.element.hidden = camera === null;
    return { microphone, camera };
  }

  toggleMicrophone(): void {
    void this.#microphone.toggle();
  }

  toggleCamera(): void {
    void this.#camera.toggle();
  }

  #show(track: MediaStreamTrack | null): void {
    const shown = this.#preview.srcObject instanceof MediaStream ? this.#preview.srcObject : null;
    if (track === (shown?.getTracks()[0] ?? null)) return;
    this.#preview.srcObject = track && new MediaStream([track]);
  }

  /** The avatar tells its level several times a second: only to those who want to know. */
  #hear(wanted: boolean): void {
    if (wanted === (this.#hearing !== null)) return;
    if (wanted) {
      this.#hearing = this.#operator?.microphoneLevel.subscribe((level) => this.#there.show(level)) ?? null;
      this.#hearing?.catch(() => (this.#hearing = null));
      return;
    }
    void this.#hearing?.then((subscription) => subscription.cancel()).catch(() => undefined);
    this.#hearing = null;
    this.#there.show(SILENCE);
  }

  /** Asks a component whether applications may send to it; one that cannot be asked has not changed its mind. */
  async #ask(componentRef: string | null): Promise<void> {
    if (componentRef === null || this.#taking.has(componentRef)) return;
    try {
      const parameters = await this.#client.getParameter(componentRef);
      const transports = parameters.find(({ name }) => name === "available_transports")?.value ?? "{}";
      const { direction = [] } = JSON.parse(transports) as { direction?: string | string[] };
      if (direction.includes("sendonly")) this.#taking.add(componentRef);
    } catch {
      // An engine that comes back changes the profile, and is asked again.
    }
  }
}
