/** Microphones and cameras that are there, refused, or gone, as a test wants. */

import type { Devices } from "../../sdk/media/capture.ts";

export class FakeTrack {
  enabled = true;
  stopped = false;
  contentHint = "";
  onended: (() => void) | null = null;
  readonly deviceId: string;

  constructor(deviceId: string) {
    this.deviceId = deviceId;
  }

  getSettings(): { deviceId: string } {
    return { deviceId: this.deviceId };
  }

  stop(): void {
    this.stopped = true;
  }
}

/** A user who says yes unless `error` names what happens instead. */
export class FakeDevices {
  error = "";
  readonly asked: MediaStreamConstraints[] = [];
  readonly tracks: FakeTrack[] = [];
  /** What the user's answer waits for. */
  hesitation: Promise<void> = Promise.resolve();

  get devices(): Devices {
    return this as unknown as Devices;
  }

  get last(): FakeTrack {
    const track = this.tracks.at(-1);
    if (!track) throw new Error("no device was given");
    return track;
  }

  async getUserMedia(constraints: MediaStreamConstraints): Promise<{ getTracks(): FakeTrack[] }> {
    this.asked.push(constraints);
    await this.hesitation;
    if (this.error !== "") throw new DOMException("", this.error);
    const wanted = (constraints.audio ?? constraints.video) as { deviceId?: { exact: string } };
    const track = new FakeTrack(wanted.deviceId?.exact ?? "default");
    this.tracks.push(track);
    return { getTracks: () => [track] };
  }

  enumerateDevices(): Promise<object[]> {
    const kinds = ["audioinput", "audioinput", "videoinput", "audiooutput"];
    return Promise.resolve(kinds.map((kind, index) => ({ kind, deviceId: `d${index}`, label: "" })));
  }
}
