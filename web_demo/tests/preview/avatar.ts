/** An avatar behind a fake gateway: components, commands, and streams with real media. */

import type { Json, JsonObject } from "../../sdk/jsonrpc/peer.ts";
import type { FakeGateway } from "../support/fake_gateway.ts";
import { DrawnAvatar, OfferingPeer, hum } from "./media.ts";
import type { SectionOf } from "./media.ts";

const URN = "urn:x-rois:def:component:";
const COMPONENTS = {
  video_streaming: "OMG::VideoStreaming",
  audio_streaming: "OMG::AudioStreaming",
  speech_synthesizer: "OMG::SpeechSynthesis",
  reaction: "OMG::Reaction",
  system_info: "OMG::SystemInformation",
  gaze: "OpenRoIS::Gaze",
  operator: "OpenRoIS::Operator",
};
const REACTIONS = ["OMG::1", "OMG::2", "OMG::3", "OMG::9", "OpenRoIS::wave", "OpenRoIS::look_around"];
const MORE_REACTIONS = ["OpenRoIS::shrug", "OpenRoIS::clap", "OpenRoIS::raise_hand", "OpenRoIS::surprise"];

const TRANSPORTS = {
  name: "available_transports",
  data_type_ref: "String",
  value: '{"direction": ["recvonly", "sendonly"]}',
};

interface Stream extends SectionOf {
  status: string;
}

export class PreviewAvatar {
  readonly engineId: string;
  /** Answers of `component_status` by component. */
  readonly status = new Map<string, string>();
  readonly drawn = new DrawnAvatar();
  /** Whether another application holds the actuators. */
  taken = false;
  /** Offers are made, but no packet gets through. */
  blocked = false;
  #present = false;
  readonly #gateway: FakeGateway;
  readonly #streams = new Map<string, Stream>();
  readonly #tracks = new Map<string, MediaStreamTrack>([["video", this.drawn.stream()]]);
  #peer: OfferingPeer | null = null;
  #count = 0;
  readonly #running = new Map<string, ReturnType<typeof setTimeout>>();

  constructor(gateway: FakeGateway, engineId: string) {
    this.#gateway = gateway;
    this.engineId = engineId;
    this.#tracks.set("audio", hum());
    setInterval(() => this.#tellLevel(), 200);
    gateway
      .on("rois.system.get_profile", () => this.#profile())
      .on("rois.command.bind", () => (this.taken ? { return_code: "OUT_OF_RESOURCES" } : {}))
      .on("rois.command.release", () => ({}))
      .on("rois.command.execute", (params) => this.#execute(params))
      .on("rois.query.query", (params) => this.#query(params))
      .on("rois.command.get_parameter", () => ({ parameters: [TRANSPORTS] }))
      .on("rois.event.subscribe", () => ({ subscribe_id: `${this.engineId}/level` }))
      .on("rois.event.unsubscribe", () => ({}))
      .on("rois.stream.connect_stream", (params) => this.#connect(params))
      .on("rois.stream.suspend_stream", (params) => this.#gate(params, "STREAMING_SUSPENDED"))
      .on("rois.stream.resume_stream", (params) => this.#gate(params, "STREAMING_RESUMED"))
      .on("rois.stream.disconnect_stream", (params) => this.#disconnect(params))
      .on("signaling.answer", (params) => this.#applyAnswer(params))
      .on("signaling.candidate", (params) => this.#candidate(params))
      .on("signaling.restart", (params) => this.#restart(params));
  }

  /** The adapter connects to the gateway. */
  arrive(): void {
    this.#present = true;
    this.#notify("rois.system.profile_changed", {});
  }

  /** The adapter dies. */
  leave(): void {
    this.#present = false;
    for (const stream of this.#streams.values()) this.#report(stream, "STREAMING_NOT_CONNECTED");
    this.#streams.clear();
    this.#peer?.connection.close();
    this.#peer = null;
    this.#notify("rois.system.profile_changed", {});
  }

  get peerId(): string {
    return this.#peer?.peerId ?? "";
  }

  #notify(method: string, params: JsonObject): void {
    if (this.#gateway.sockets.length > 0) this.#gateway.notify(method, params);
  }

  #profile(): JsonObject {
    const present = this.#present ? Object.entries(COMPONENTS) : [];
    const profiles = present.map(
      ([name, type]) => [`${this.engineId}/${name}`, { identifier: { code: URN + type }, name }] as const,
    );
    const avatar = { identifier: { code: this.engineId }, component_ids: profiles.map(([ref]) => ref) };
    return {
      profile: { identifier: { code: "gateway" }, sub_profiles: this.#present ? [avatar] : [] },
      component_profiles: Object.fromEntries(profiles),
    };
  }

  #query({ query_type, condition }: JsonObject): JsonObject {
    const result = (name: string, value: string): JsonObject => ({
      results: [{ name, data_type_ref: "string", value }],
    });
    switch (query_type) {
      case "component_status": {
        const component = /\/(\w+)'/.exec(String(condition))?.[1] ?? "";
        return result("status", this.status.get(component) ?? "READY");
      }
      case "synthesizable_languages":
        return result(
          "languages",
          JSON.stringify(["en", "en-GB", "de", "fr", "es", "ja", "it", "nl", "pt-BR"]),
        );
      case "available_reactions":
        return result(
          "available_reactions",
          JSON.stringify([...REACTIONS, ...MORE_REACTIONS].map((code) => `urn:x-rois:def:reaction:${code}`)),
        );
      case "robot_position":
        return result("timestamp", new Date().toISOString());
      default:
        return { return_code: "UNSUPPORTED" };
    }
  }

  #execute({ command_unit_list }: JsonObject): JsonObject {
    const units = command_unit_list as { component_ref: string; command_type: string; command_id: string }[];
    if (this.taken) return { return_code: "OUT_OF_RESOURCES" };
    for (const { component_ref, command_type, command_id } of units) {
      if (command_type === "start") this.#start(component_ref, command_id);
      else {
        if (command_type === "stop") this.#stop("ABORT");
        setTimeout(() => this.#notify("rois.command.completed", { command_id, status: "OK" }), 5);
      }
    }
    return {};
  }

  #start(componentRef: string, commandId: string): void {
    this.#stop("ABORT");
    const speaks = componentRef.endsWith("/speech_synthesizer");
    const moving = setInterval(() => {
      if (speaks) this.drawn.mouth = Math.random();
      else this.drawn.nod = 14 * Math.abs(Math.sin(performance.now() / 180));
    }, 80);
    const end = setTimeout(() => this.#stop("OK"), speaks ? 2600 : 1400);
    this.#running.set(commandId, end);
    setTimeout(() => clearInterval(moving), speaks ? 2600 : 1400);
  }

  #stop(status: string): void {
    for (const [command_id, timer] of this.#running) {
      clearTimeout(timer);
      this.#notify("rois.command.completed", { command_id, status });
    }
    this.#running.clear();
    this.drawn.mouth = 0;
    this.drawn.nod = 0;
  }

  /** Sends speech levels while a microphone is connected. */
  #tellLevel(): void {
    const heard = [...this.#streams.values()].some(
      ({ kind, direction }) => kind === "audio" && direction === "sendonly",
    );
    if (!heard) return;
    const rms = -38 + 20 * Math.abs(Math.sin(performance.now() / 700));
    const value = (name: string, db: number): JsonObject => ({
      name,
      data_type_ref: "double",
      value: db.toFixed(1),
    });
    this.#notify("rois.event.notify_event", {
      event_id: `${this.engineId}/e${++this.#count}`,
      event_type: "microphone_level",
      subscribe_id: `${this.engineId}/level`,
      results: [value("rms", rms), value("peak", rms + 9)],
    });
  }

  #connect({ component_ref, parameters }: JsonObject): JsonObject {
    if (!this.#present) return { return_code: "UNSUPPORTED" };
    const componentRef = String(component_ref);
    const kind = componentRef.endsWith("/video_streaming") ? "video" : "audio";
    const streamId = `${this.engineId}/${(++this.#count).toString(16).padStart(32, "0")}`;
    const direction = JSON.stringify(parameters).includes("sendonly") ? "sendonly" : "recvonly";
    const stream: Stream = { streamId, componentRef, kind, direction, status: "STREAMING_NOT_RUNNING" };
    this.#streams.set(streamId, stream);
    setTimeout(() => void this.#offer(), 20);
    return { stream_id: streamId };
  }

  #disconnect({ stream_id }: JsonObject): JsonObject {
    const stream = this.#streams.get(String(stream_id));
    if (!stream) return { return_code: "UNSUPPORTED" };
    this.#streams.delete(stream.streamId);
    setTimeout(() => {
      this.#report(stream, "STREAMING_NOT_CONNECTED");
      void this.#offer();
    }, 5);
    return {};
  }

  #gate({ stream_id }: JsonObject, status: string): JsonObject {
    const stream = this.#streams.get(String(stream_id));
    if (!stream) return { return_code: "UNSUPPORTED" };
    const sender = this.#peer?.sender(stream.streamId);
    void sender?.replaceTrack(
      status === "STREAMING_SUSPENDED" ? null : (this.#tracks.get(stream.kind) ?? null),
    );
    setTimeout(() => this.#report(stream, status), 5);
    return {};
  }

  async #offer(replaces?: string): Promise<void> {
    this.#peer ??= new OfferingPeer(
      `${this.engineId}/${(++this.#count).toString(16).padStart(32, "f")}`,
      (method, params) => {
        if (!this.blocked) return this.#notify(method, params);
        // Without the engine's addresses there is no way to it.
        if (method !== "signaling.offer") return;
        this.#notify(method, { ...params, sdp: withoutCandidates(params["sdp"]) });
      },
    );
    await this.#peer.offer([...this.#streams.values()], this.#tracks, replaces);
  }

  async #applyAnswer({ sdp }: JsonObject): Promise<JsonObject> {
    await this.#peer?.applyAnswer(this.blocked ? withoutCandidates(sdp) : String(sdp));
    if (this.blocked) return {};
    setTimeout(() => {
      for (const stream of this.#streams.values()) {
        if (stream.status === "STREAMING_NOT_RUNNING") this.#report(stream, "STREAMING_RUNNING");
      }
    }, 150);
    return {};
  }

  async #candidate(params: JsonObject): Promise<JsonObject> {
    if (!this.blocked && params["peer_id"] === this.#peer?.peerId) await this.#peer?.candidate(params);
    return {};
  }

  #restart({ peer_id }: JsonObject): JsonObject {
    if (peer_id !== this.#peer?.peerId) return { return_code: "UNSUPPORTED" };
    const old = this.#peer;
    this.#peer = null;
    setTimeout(() => old?.connection.close(), 3000);
    setTimeout(() => void this.#offer(String(peer_id)), 20);
    return {};
  }

  #report(stream: Stream, status: string): void {
    stream.status = status === "STREAMING_RESUMED" ? "STREAMING_RUNNING" : status;
    this.#notify("rois.stream.notify_stream_status", {
      stream_id: stream.streamId,
      component_ref: stream.componentRef,
      status,
      timestamp: new Date().toISOString(),
    });
  }
}

function withoutCandidates(sdp: Json | undefined): string {
  return String(sdp).replaceAll(/^a=candidate.*\r\n/gm, "");
}
