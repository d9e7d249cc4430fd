/** The engine's half of the media, in the same browser: a drawn avatar, a voice, and an offering peer connection. */

import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";

const WIDTH = 640;
const HEIGHT = 360;

/** Draws a figure thirty times a second. */
export class DrawnAvatar {
  readonly #context: CanvasRenderingContext2D;
  readonly #canvas = document.createElement("canvas");
  /** 0 (shut) to 1 (open). */
  mouth = 0;
  /** The head's offset in pixels. */
  nod = 0;

  constructor() {
    this.#canvas.width = WIDTH;
    this.#canvas.height = HEIGHT;
    const context = this.#canvas.getContext("2d");
    if (!context) throw new Error("this browser has no canvas");
    this.#context = context;
    setInterval(() => this.#draw(), 33);
  }

  stream(): MediaStreamTrack {
    const [track] = this.#canvas.captureStream(30).getVideoTracks();
    if (!track) throw new Error("the canvas gives no track");
    return track;
  }

  #draw(): void {
    const paint = this.#context;
    const time = performance.now() / 1000;
    const light = paint.createRadialGradient(420, 80, 20, 320, 180, 420);
    light.addColorStop(0, "#5c6f8f");
    light.addColorStop(1, "#1e2635");
    paint.fillStyle = light;
    paint.fillRect(0, 0, WIDTH, HEIGHT);
    const breath = Math.sin(time * 1.6) * 2;
    this.#ellipse("#3c5a77", 320, 382 + breath, 170, 120);
    this.#ellipse("#d8a98a", 320, 275 + breath, 42, 60);
    const y = 168 + breath + this.nod + Math.sin(time * 0.7) * 3;
    const x = 320 + Math.sin(time * 0.5) * 6;
    this.#ellipse("#4a3428", x, y - 22, 88, 96);
    this.#ellipse("#e9bd9f", x, y, 74, 88);
    const blink = Math.sin(time * 0.9) > 0.985 ? 0.1 : 1;
    for (const side of [-1, 1]) {
      this.#ellipse("#ffffff", x + side * 29, y - 12, 13, 9 * blink);
      this.#ellipse("#2d3b4e", x + side * 29 + Math.sin(time * 0.5) * 3, y - 12, 6, 6 * blink);
      this.#ellipse("#4a3428", x + side * 29, y - 32, 15, 3);
    }
    this.#ellipse("#d5a184", x, y + 14, 7, 10);
    this.#ellipse("#9c4a4a", x, y + 46, 20, 3 + 13 * this.mouth);
  }

  #ellipse(colour: string, x: number, y: number, rx: number, ry: number): void {
    this.#context.fillStyle = colour;
    this.#context.beginPath();
    this.#context.ellipse(x, y, rx, ry, 0, 0, 2 * Math.PI);
    this.#context.fill();
  }
}

/** A quiet hum that swells while the avatar speaks. */
export function hum(): MediaStreamTrack {
  const audio = new AudioContext();
  const tone = new OscillatorNode(audio, { frequency: 220 });
  const volume = new GainNode(audio, { gain: 0.02 });
  const sink = audio.createMediaStreamDestination();
  tone.connect(volume).connect(sink);
  tone.start();
  const [track] = sink.stream.getAudioTracks();
  if (!track) throw new Error("the audio context gives no track");
  return track;
}

export interface SectionOf {
  readonly streamId: string;
  readonly componentRef: string;
  readonly kind: "video" | "audio";
  /** As the application sees it. */
  readonly direction: "recvonly" | "sendonly";
}

/** Offers a set of streams on one peer connection, as an engine does. */
export class OfferingPeer {
  readonly peerId: string;
  readonly connection = new RTCPeerConnection({ bundlePolicy: "max-bundle" });
  readonly #notify: (method: string, params: JsonObject) => void;
  readonly #sections = new Map<string, RTCRtpTransceiver>();
  #generation = 0;
  #busy = false;
  /** Who asked for an offer while one was unanswered. */
  #next: (() => void) | null = null;

  constructor(peerId: string, notify: (method: string, params: JsonObject) => void) {
    this.peerId = peerId;
    this.#notify = notify;
    this.connection.onicecandidate = ({ candidate }) => {
      const { candidate: line, sdpMid, sdpMLineIndex } = candidate ?? {};
      notify("signaling.candidate", {
        peer_id: peerId,
        generation: this.#generation,
        candidate: line ?? null,
        sdp_mid: sdpMid ?? null,
        sdp_m_line_index: sdpMLineIndex ?? null,
      });
    };
  }

  sender(streamId: string): RTCRtpSender | undefined {
    return this.#sections.get(streamId)?.sender;
  }

  /** Makes the sections what the streams are now. One offer is unanswered at most; another one waits for it. */
  async offer(
    streams: readonly SectionOf[],
    tracks: ReadonlyMap<string, MediaStreamTrack>,
    replaces?: string,
  ): Promise<void> {
    if (this.#busy) {
      this.#next = () => void this.offer(streams, tracks);
      return;
    }
    this.#busy = true;
    for (const [streamId, transceiver] of this.#sections) {
      if (streams.some((stream) => stream.streamId === streamId)) continue;
      transceiver.direction = "inactive";
      await transceiver.sender.replaceTrack(null);
    }
    for (const { streamId, kind, direction } of streams) {
      if (this.#sections.has(streamId)) continue;
      const transceiver =
        direction === "sendonly"
          ? this.connection.addTransceiver(kind, { direction: "recvonly" })
          : this.connection.addTransceiver(tracks.get(kind) ?? kind, { direction: "sendonly" });
      this.#sections.set(streamId, transceiver);
    }
    await this.connection.setLocalDescription();
    this.#generation += 1;
    this.#notify("signaling.offer", {
      peer_id: this.peerId,
      generation: this.#generation,
      sdp: this.connection.localDescription?.sdp ?? "",
      streams: streams.map(({ streamId, componentRef, kind, direction }) => ({
        mid: this.#sections.get(streamId)?.mid ?? "",
        stream_id: streamId,
        component_ref: componentRef,
        kind,
        direction,
      })),
      ...(replaces !== undefined && { replaces }),
    });
  }

  async applyAnswer(sdp: string): Promise<void> {
    await this.connection.setRemoteDescription({ type: "answer", sdp });
    this.#busy = false;
    this.#next?.();
    this.#next = null;
  }

  async candidate(params: JsonObject): Promise<void> {
    const { candidate, sdp_mid, sdp_m_line_index } = params;
    if (typeof candidate !== "string") return;
    const init = {
      candidate,
      sdpMid: sdp_mid as string | null,
      sdpMLineIndex: sdp_m_line_index as number | null,
    };
    await this.connection.addIceCandidate(init);
  }
}
