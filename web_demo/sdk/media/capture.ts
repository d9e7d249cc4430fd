/** A microphone or camera of this machine, from the user's consent to the end of its use. */

import { Emitter } from "../jsonrpc/events.ts";
import type { MediaKind } from "../rois/generated/types.ts";

export interface CaptureProblem {
  readonly kind:
    /** The page came over plain HTTP from another machine: browsers give it no devices. */
    | "insecure"
    /** The user, or a policy, does not allow it. */
    | "refused"
    /** There is none, or the one that was chosen is not there. */
    | "no-device"
    /** Another program has it, or it does not work. */
    | "in-use"
    /** It was unplugged, or taken away by the system or the user, while it was used. */
    | "lost";
  /** What has happened and what to do, in a sentence for a person. */
  readonly detail: string;
}

/** What is used of `navigator.mediaDevices`. */
export type Devices = Pick<MediaDevices, "getUserMedia" | "enumerateDevices">;

/** Default constraints of each kind of device. */
const USUAL: Readonly<Record<MediaKind, MediaTrackConstraints>> = {
  // The avatar's own voice comes out of the speakers beside this microphone.
  audio: { echoCancellation: true, noiseSuppression: true, autoGainControl: true },
  video: { width: { ideal: 1280 }, height: { ideal: 720 }, frameRate: { ideal: 30 } },
};

const NAMES: Readonly<Record<MediaKind, string>> = { audio: "microphone", video: "camera" };

/** Capture of one device: asked for by `open`, released by `close`, when its light goes out. */
export class Capture {
  readonly kind: MediaKind;
  readonly #constraints: MediaTrackConstraints;
  readonly #devices: Devices | undefined;
  readonly #events = new Emitter<{ change: undefined }>();
  #track: MediaStreamTrack | null = null;
  #problem: CaptureProblem | null = null;
  #deviceId: string | null = null;
  /** Number of requests for a device: consent may come after the request was withdrawn. */
  #asked = 0;

  constructor(
    kind: MediaKind,
    constraints: MediaTrackConstraints = {},
    devices: Devices | undefined = globalThis.navigator?.mediaDevices,
  ) {
    this.kind = kind;
    this.#constraints = { ...USUAL[kind], ...constraints };
    this.#devices = devices;
  }

  /** The captured track; null while the device is not in use. */
  get track(): MediaStreamTrack | null {
    return this.#track;
  }

  /** Why there is no device; null when nothing is wrong. */
  get problem(): CaptureProblem | null {
    return this.#problem;
  }

  /** The device that is in use, or was last; null for the system's choice. */
  get deviceId(): string | null {
    return this.#track?.getSettings().deviceId ?? this.#deviceId;
  }

  /** Calls the listener when track, problem or device have changed. */
  onChange(listener: () => void): () => void {
    return this.#events.on("change", listener);
  }

  /**
   * Takes the device into use, asking the user where the browser wants that. Returns whether there is a track; why not
   * stands in `problem`.
   *
   * @param deviceId another device than before; the one in use stays so until this one is there
   */
  async open(deviceId: string | null = this.#deviceId): Promise<boolean> {
    if (this.#track && deviceId === this.#deviceId) return true;
    const asked = ++this.#asked;
    try {
      const track = await this.#ask(deviceId);
      if (asked !== this.#asked) {
        track.stop();
        return this.#track !== null;
      }
      this.#deviceId = deviceId;
      this.#use(track);
    } catch (error) {
      if (asked === this.#asked) this.#fail(describe(error, this.kind));
    }
    return this.#track !== null;
  }

  /** Lets go of the device. */
  close(): void {
    this.#asked += 1;
    this.#problem = null;
    this.#drop();
    this.#events.emit("change", undefined);
  }

  /** The devices of this kind; before the user's consent browsers hide their names. */
  async list(): Promise<MediaDeviceInfo[]> {
    const all = (await this.#devices?.enumerateDevices().catch(() => [])) ?? [];
    return all.filter(({ kind, deviceId }) => kind === `${this.kind}input` && deviceId !== "");
  }

  async #ask(deviceId: string | null): Promise<MediaStreamTrack> {
    if (!this.#devices) throw new DOMException("", isInsecure() ? INSECURE : "NotFoundError");
    const wanted = { ...this.#constraints, ...(deviceId !== null && { deviceId: { exact: deviceId } }) };
    const stream = await this.#devices.getUserMedia({ [this.kind]: wanted });
    const [track] = stream.getTracks();
    if (!track) throw new DOMException("", "NotFoundError");
    return track;
  }

  #use(track: MediaStreamTrack): void {
    this.#drop();
    this.#track = track;
    this.#problem = null;
    if (this.kind === "audio") track.contentHint = "speech";
    track.onended = () => {
      this.#drop();
      this.#fail({ kind: "lost", detail: WORDS.lost(NAMES[this.kind]) });
    };
    this.#events.emit("change", undefined);
  }

  #drop(): void {
    if (!this.#track) return;
    this.#track.onended = null;
    this.#track.stop();
    this.#track = null;
  }

  #fail(problem: CaptureProblem): void {
    this.#problem = problem;
    this.#events.emit("change", undefined);
  }
}

/** Not a name of the browser's: there it is the whole of `mediaDevices` that is missing. */
const INSECURE = "InsecureContext";

const WORDS: Readonly<Record<CaptureProblem["kind"], (device: string) => string>> = {
  insecure: (device) =>
    `Browsers give a page the ${device} only over HTTPS or from this machine: open it as https:// or http://localhost.`,
  refused: (device) =>
    `This page may not use the ${device}. Allow it beside the address, or in the system's privacy settings, and turn it on again.`,
  "no-device": (device) => `No ${device} was found. Plug one in or choose another, and turn it on again.`,
  "in-use": (device) =>
    `The ${device} does not start; another program may be using it. Close that, and turn it on again.`,
  lost: (device) =>
    `The ${device} was unplugged or taken away. Plug it in or choose another, and turn it on again.`,
};

function isInsecure(): boolean {
  return (globalThis as { isSecureContext?: boolean }).isSecureContext === false;
}

function describe(error: unknown, device: MediaKind): CaptureProblem {
  const kind = problemKind(error instanceof Error || error instanceof DOMException ? error.name : "");
  return { kind, detail: WORDS[kind](NAMES[device]) };
}

function problemKind(name: string): CaptureProblem["kind"] {
  switch (name) {
    case INSECURE:
      return "insecure";
    case "NotAllowedError":
    case "SecurityError":
      return "refused";
    case "NotFoundError":
    case "OverconstrainedError":
      return "no-device";
    default:
      return "in-use";
  }
}
