/** Card of the operator: microphone and camera on their way to the avatar, and what arrives there. */

import type { Client, Purpose } from "../../sdk/index.ts";
import type { LocalStream, MediaReceiver } from "../../sdk/media/index.ts";
import type { PageBody } from "../model/bodies.ts";
import type { GiveBack } from "../model/body_control.ts";
import { ConsentPanel } from "./consent.ts";
import { DeviceControl } from "./device_control.ts";
import { NOTHING_CHOSEN } from "../model/consent.ts";
import { sendingWords } from "../model/device_words.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";
import { HearingPanel } from "../senses/hearing_panel.ts";
import { SightPanel } from "../senses/sight_panel.ts";

export class OperatorCard {
  readonly #client: Client;
  readonly #receiver: MediaReceiver;
  readonly #element = byRole("card-operator", HTMLElement);
  readonly #sending = byTestId("sending", HTMLElement);
  readonly #sight: SightPanel;
  readonly #hearing: HearingPanel;
  readonly #microphone: DeviceControl;
  readonly #camera: DeviceControl;
  readonly #consent: ConsentPanel;
  /** The streams to the body that is shown. */
  #streams: readonly LocalStream[] = [];
  /** Whether that body keeps to what is consented to; others are told nothing. */
  #asksConsent = false;
  /** The connection of each stream that was told last. */
  readonly #told = new Map<LocalStream, string | null>();
  #barred = "";
  /** Components that accept streams of applications. */
  readonly #accepting = new Set<string>();
  /** Is called when a device is switched on or off. */
  onChange: () => void = () => undefined;
  /** Is called when something else is consented to, or can be sent. */
  onConsent: () => void = () => undefined;
  readonly #on = { audio: false, video: false };

  /** @param take takes control, which is held while a device is on */
  constructor(client: Client, receiver: MediaReceiver, take: () => Promise<GiveBack>) {
    this.#client = client;
    this.#receiver = receiver;
    this.#hearing = new HearingPanel(client, () => this.#showSending());
    this.#sight = new SightPanel(client, () => this.#showSending());
    this.#microphone = new DeviceControl("audio", this.#hearing.element, take, (track) => {
      this.#on.audio = track !== null;
      this.#hearing.show(track);
      this.#showSending();
    });
    this.#camera = new DeviceControl("video", this.#sight.element, take, (track) => {
      this.#on.video = track !== null;
      this.#sight.show(track);
      this.#showSending();
    });
    this.#consent = new ConsentPanel(
      () => this.#stateConsent(),
      () => {
        this.#stateConsent();
        this.off("");
      },
    );
    this.#element.append(
      make("h2", { id: "operator-title" }, "You"),
      this.#consent.element,
      make("div", { class: "devices" }, this.#microphone.element, this.#camera.element),
    );
  }

  /** The streams to the body, for the browser's console; null where it takes none. */
  async watch(body: PageBody): Promise<{ microphone: LocalStream | null; camera: LocalStream | null }> {
    const { video, audio } = body;
    await Promise.all([this.#askDirection(audio), this.#askDirection(video)]);
    this.#hearing.setComponents(body.operator, body.hearing, body.progress);
    this.#sight.setComponents(body.sight, body.enrolment);
    const microphone =
      audio !== null && this.#accepting.has(audio) ? this.#receiver.sending(audio, "audio") : null;
    const limits = { width: 640, height: 360, fps: 30, max_bitrate: 1_000_000 };
    const camera =
      video !== null && this.#accepting.has(video)
        ? this.#receiver.sending(video, "video", { limits })
        : null;
    this.#asksConsent = body.visitors !== null;
    this.#consent.element.hidden = !this.#asksConsent;
    this.#streams = [microphone, camera].filter((stream) => stream !== null);
    this.#stateConsent();
    for (const stream of this.#streams) {
      if (this.#told.has(stream)) continue;
      this.#told.set(stream, null);
      stream.on("change", () => this.#connected(stream));
    }
    this.#microphone.watch(microphone);
    this.#camera.watch(camera);
    this.#element.hidden = microphone === null && camera === null;
    this.#microphone.element.hidden = microphone === null;
    this.#camera.element.hidden = camera === null;
    return { microphone, camera };
  }

  /** Why nothing can be sent; empty where it can. */
  set barred(barred: string) {
    this.#barred = barred;
    this.#bar();
  }

  /** What is on, in words; empty for nothing. */
  get sending(): string {
    return sendingWords(this.#on.audio, this.#on.video);
  }

  /** Lets go of the devices that are in use. @param why in a sentence */
  off(why: string): void {
    for (const device of [this.#microphone, this.#camera]) void device.off(why);
  }

  /** Says to the body what is consented to, from now on and whenever something is sent. */
  #stateConsent(): void {
    this.#bar();
    this.#hearing.agrees = !this.#asksConsent || this.#consent.purposes.includes("transfer");
    if (!this.#asksConsent) return;
    for (const stream of this.#streams) {
      // A body that cannot be told now is told when the stream is connected again.
      stream.setConsent(this.#consent.purposes).catch(() => undefined);
    }
  }

  /** Learns which visitor this page is, once it sends something. */
  #connected(stream: LocalStream): void {
    const { streamId } = stream;
    if (!this.#asksConsent || streamId === this.#told.get(stream)) return;
    this.#told.set(stream, streamId);
    if (streamId === null) return;
    const learn = (): void => {
      this.#hearing.visitorRef = this.#sight.visitorRef = stream.visitorRef;
    };
    stream.setConsent(this.#consent.purposes).then(learn, () => undefined);
  }

  #bar(): void {
    this.#microphone.barred = this.#camera.barred = this.microphoneBarred;
    this.onConsent();
  }

  /** The microphone, for what switches it beside its button; null where the body takes no sound. */
  get microphone(): { readonly control: DeviceControl; readonly stream: LocalStream } | null {
    const stream = this.#streams.find(({ kind }) => kind === "audio");
    return stream ? { control: this.#microphone, stream } : null;
  }

  /** Why the microphone cannot be switched on; empty where it can. */
  get microphoneBarred(): string {
    const chosen = !this.#asksConsent || this.#consent.purposes.length > 0;
    return this.#barred || (chosen ? "" : NOTHING_CHOSEN);
  }

  /** The visitor that this page is; empty while that is not known. */
  get visitorRef(): string {
    return this.#hearing.visitorRef;
  }

  /** The purposes that are not consented to, of these. */
  missing(purposes: readonly Purpose[]): Purpose[] {
    return this.#asksConsent ? purposes.filter((each) => !this.#consent.purposes.includes(each)) : [];
  }

  /** Consents to more. */
  consentTo(purposes: readonly Purpose[]): void {
    this.#consent.add(purposes);
    this.#stateConsent();
  }

  toggleMicrophone(): void {
    void this.#microphone.toggle();
  }

  toggleCamera(): void {
    void this.#camera.toggle();
  }

  /** Shows in the header what leaves this machine. */
  #showSending(): void {
    // The panels call this while they are made.
    if (!this.#camera) return;
    this.#microphone.used = this.#hearing.listens ? "listened to" : "";
    this.#camera.used = this.#sight.looks ? "looked at" : "";
    const words = this.sending;
    this.#sending.hidden = words === "";
    setText(this.#sending, words);
    this.#consent.sending = words !== "";
    this.onChange();
  }

  /** Asks a component whether applications may send to it; without an answer the last one counts. */
  async #askDirection(componentRef: string | null): Promise<void> {
    if (componentRef === null || this.#accepting.has(componentRef)) return;
    try {
      const parameters = await this.#client.getParameter(componentRef);
      const transports = parameters.find(({ name }) => name === "available_transports")?.value ?? "{}";
      const { direction = [] } = JSON.parse(transports) as { direction?: string | string[] };
      if (direction.includes("sendonly")) this.#accepting.add(componentRef);
    } catch {
      // An engine that comes back changes the profile, and is asked again.
    }
  }
}
