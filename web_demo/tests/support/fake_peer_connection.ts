/** As much of RTCPeerConnection as an answerer needs; what arrives on it is set by the test. */

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
  readonly receivers = new Map<string, FakeReceiver>();
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
      if (!this.receivers.has(mid)) {
        const id = `${FakePeerConnection.all.indexOf(this)}/${mid}`;
        this.receivers.set(mid, new FakeReceiver(id, kind === "video" ? "video" : "audio"));
      }
    }
    return Promise.resolve();
  }

  createAnswer(): Promise<{ sdp: string }> {
    return Promise.resolve({ sdp: `answer ${this.#offers}` });
  }

  setLocalDescription(description: { sdp: string }): Promise<void> {
    this.localDescription = description;
    this.onicecandidate?.({ candidate: { candidate: "candidate:1", sdpMid: "0", sdpMLineIndex: 0 } });
    return Promise.resolve();
  }

  getTransceivers(): { mid: string; receiver: FakeReceiver }[] {
    return [...this.receivers].map(([mid, receiver]) => ({ mid, receiver }));
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
