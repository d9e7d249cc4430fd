/** As much of RTCPeerConnection as an answerer needs; what arrives on it, and leaves, is set by the test. */

export class FakeSender {
  track: object | null = null;
  units = 0;
  encodings: Record<string, number>[] = [{}];
  readonly #kind: "video" | "audio";

  constructor(kind: "video" | "audio") {
    this.#kind = kind;
  }

  replaceTrack(track: object | null): Promise<void> {
    this.track = track;
    return Promise.resolve();
  }

  getParameters(): { encodings: Record<string, number>[] } {
    return { encodings: this.encodings.map((each) => ({ ...each })) };
  }

  setParameters({ encodings }: { encodings: Record<string, number>[] }): Promise<void> {
    this.encodings = encodings;
    return Promise.resolve();
  }

  getStats(): Promise<Map<string, object>> {
    const units = this.units;
    const outbound = {
      type: "outbound-rtp",
      kind: this.#kind,
      framesSent: units,
      packetsSent: units,
      bytesSent: units * 100,
    };
    return Promise.resolve(new Map([["out", outbound]]));
  }
}

export interface FakeTransceiver {
  readonly mid: string;
  readonly receiver: FakeReceiver;
  readonly sender: FakeSender;
  direction: string;
}

export class FakeReceiver {
  readonly track: { readonly id: string };
  readonly kind: "video" | "audio";
  jitterBufferTarget: number | null = null;
  units = 0;

  constructor(id: string, kind: "video" | "audio") {
    this.track = { id };
    this.kind = kind;
  }

  getStats(): Promise<Map<string, object>> {
    const { kind, units } = this;
    const inbound = {
      type: "inbound-rtp",
      kind,
      framesDecoded: units,
      packetsReceived: units,
      bytesReceived: units * 100,
    };
    return Promise.resolve(new Map([["in", inbound]]));
  }
}

/** A data channel that is open. */
export class FakeChannel {
  readonly options: object;
  /** Texts that were sent. */
  readonly sent: string[] = [];
  /** Binary messages that were sent. */
  readonly frames: ArrayBuffer[] = [];
  readyState = "open";
  bufferedAmount = 0;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;

  constructor(options: object) {
    this.options = options;
  }

  send(data: string | ArrayBuffer): void {
    if (typeof data === "string") this.sent.push(data);
    else this.frames.push(data);
  }

  close(): void {
    this.readyState = "closed";
    this.onclose?.();
  }
}

export class FakePeerConnection {
  static readonly all: FakePeerConnection[] = [];
  static refuse = false;

  connectionState: RTCPeerConnectionState = "new";
  iceConnectionState: RTCIceConnectionState = "new";
  localDescription: { sdp: string } | null = null;
  onicecandidate: ((event: { candidate: object | null }) => void) | null = null;
  onconnectionstatechange: (() => void) | null = null;
  readonly configuration: RTCConfiguration;
  readonly candidates: (object | undefined)[] = [];
  readonly transceivers = new Map<string, FakeTransceiver>();
  readonly channels = new Map<string, FakeChannel>();
  #offers = 0;

  constructor(configuration: RTCConfiguration) {
    this.configuration = configuration;
    FakePeerConnection.all.push(this);
  }

  /** An offer's SDP is a list of m-sections: `0 video,1 audio`. */
  setRemoteDescription({ sdp }: { sdp: string }): Promise<void> {
    if (FakePeerConnection.refuse) return Promise.reject(new Error("refused"));
    this.#offers += 1;
    for (const section of sdp.split(",")) {
      const [mid = "", kind = ""] = section.split(" ");
      if (this.transceivers.has(mid) || mid === "m=application") continue;
      const id = `${FakePeerConnection.all.indexOf(this)}/${mid}`;
      const of = kind === "video" ? "video" : "audio";
      const ends = { receiver: new FakeReceiver(id, of), sender: new FakeSender(of) };
      this.transceivers.set(mid, { mid, ...ends, direction: "recvonly" });
    }
    return Promise.resolve();
  }

  createDataChannel(label: string, options: object): FakeChannel {
    const channel = new FakeChannel(options);
    this.channels.set(label, channel);
    return channel;
  }

  channel(label: string): FakeChannel {
    const found = this.channels.get(label);
    if (!found) throw new Error(`there is no channel ${label}`);
    return found;
  }

  createAnswer(): Promise<{ sdp: string }> {
    return Promise.resolve({ sdp: `answer ${this.#offers}` });
  }

  setLocalDescription(description: { sdp: string }): Promise<void> {
    this.localDescription = description;
    this.onicecandidate?.({ candidate: { candidate: "candidate:1", sdpMid: "0", sdpMLineIndex: 0 } });
    return Promise.resolve();
  }

  /** What arrives, by section. */
  get receivers(): Map<string, FakeReceiver> {
    return new Map([...this.transceivers].map(([mid, { receiver }]) => [mid, receiver]));
  }

  section(mid: string): FakeTransceiver {
    const found = this.transceivers.get(mid);
    if (!found) throw new Error(`there is no section ${mid}`);
    return found;
  }

  getTransceivers(): FakeTransceiver[] {
    return [...this.transceivers.values()];
  }

  addIceCandidate(candidate: object | undefined): Promise<void> {
    this.candidates.push(candidate);
    return Promise.resolve();
  }

  close(): void {
    this.connectionState = "closed";
  }

  become(state: RTCPeerConnectionState): void {
    this.connectionState = state;
    this.onconnectionstatechange?.();
  }
}
