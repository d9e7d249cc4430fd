import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { MediaReceiver } from "../../sdk/media/receiver.ts";
import { nextVerb } from "../../sdk/media/reconciler.ts";
import type { RemoteStream } from "../../sdk/media/stream.ts";
import { Client } from "../../sdk/rois/client.ts";
import { FakeGateway } from "../support/fake_gateway.ts";
import { FakePeerConnection } from "../support/fake_peer_connection.ts";

const VIDEO = "avatar/video";
const AUDIO = "avatar/audio";
const STEADY = { first: 500, factor: 1.5, random: (): number => 1 };

let gateway: FakeGateway;
let client: Client;
let receiver: MediaReceiver;
let video: RemoteStream;
let count: number;

const pass = (ms: number): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);

const peer = (index = -1): FakePeerConnection => {
  const found = FakePeerConnection.all.at(index);
  if (!found) throw new Error("no peer connection was made");
  return found;
};

const status = (stream: RemoteStream, value: string): void =>
  gateway.notify("rois.stream.notify_stream_status", {
    stream_id: stream.streamId ?? "",
    component_ref: stream.componentRef,
    status: value,
    timestamp: "",
  });

function offer(
  peer_id: string,
  generation: number,
  streams: [string, RemoteStream][],
  more: JsonObject = {},
): void {
  gateway.notify("signaling.offer", {
    peer_id,
    generation,
    sdp: streams.map(([mid, stream]) => `${mid} ${stream.kind}`).join(","),
    streams: streams.map(([mid, stream]) => ({
      mid,
      stream_id: stream.streamId ?? "",
      component_ref: stream.componentRef,
      kind: stream.kind,
      direction: "recvonly",
    })),
    ...more,
  });
}

/** Connects the video, lets the engine offer peer "p1", and lets frames flow in every second from then on. */
async function running(): Promise<void> {
  await video.connect();
  offer("p1", 1, [["0", video]]);
  await pass(1);
  peer().become("connected");
  status(video, "STREAMING_RUNNING");
  await flow(1000);
}

/** Lets time pass in which every second 30 frames arrive on the given peer connection. */
async function flow(ms: number, from = peer(), mid = "0"): Promise<void> {
  for (let passed = 0; passed < ms; passed += 500) {
    const into = from.receivers.get(mid);
    if (into) into.units += 15;
    await pass(500);
  }
}

beforeEach(async () => {
  vi.useFakeTimers();
  FakePeerConnection.all.length = 0;
  FakePeerConnection.refuse = false;
  count = 0;
  gateway = new FakeGateway();
  gateway.on("rois.stream.connect_stream", () => ({ stream_id: `avatar/s${++count}` }));
  for (const verb of ["disconnect", "suspend", "resume"])
    gateway.on(`rois.stream.${verb}_stream`, () => ({}));
  for (const method of ["answer", "candidate", "restart"]) gateway.on(`signaling.${method}`, () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: STEADY });
  receiver = new MediaReceiver(client, {
    backoff: STEADY,
    codecs: (kind) => [`${kind}/x`],
    createPeerConnection: (configuration) =>
      new FakePeerConnection(configuration) as unknown as RTCPeerConnection,
  });
  video = receiver.stream(VIDEO, "video");
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
});

describe("nextVerb", () => {
  it.each([
    ["running", false, false, "connect"],
    ["running", true, false, null],
    ["running", true, true, "resume"],
    ["suspended", false, false, "connect"],
    ["suspended", true, false, "suspend"],
    ["suspended", true, true, null],
    ["disconnected", false, false, null],
    ["disconnected", true, false, "disconnect"],
    ["disconnected", true, true, "disconnect"],
  ] as const)("wanted %s, connected %s, suspended %s: %s", (desire, connected, suspended, verb) => {
    expect(nextVerb(desire, connected, suspended)).toBe(verb);
  });
});

describe("connecting", () => {
  it("asks for the ICE servers first, then names what it can decode", async () => {
    gateway.on("signaling.ice_servers", () => ({ ice_servers: [{ urls: ["stun:s"] }], ttl: 600 }));
    await Promise.all([video.connect(), receiver.stream(AUDIO, "audio").connect()]);
    expect(gateway.calls.slice(2).map((call) => call.method)).toEqual([
      "signaling.ice_servers",
      "rois.stream.connect_stream",
      "rois.stream.connect_stream",
    ]);
    expect(gateway.called("rois.stream.connect_stream")[0]).toEqual({
      component_ref: VIDEO,
      parameters: [
        { name: "encoding_parameters", data_type_ref: "string", value: '{"codecs":["video/x"]}' },
        { name: "transport_parameters", data_type_ref: "string", value: '{"direction":"recvonly"}' },
      ],
    });
    expect(video).toMatchObject({ streamId: "avatar/s1", status: "STREAMING_NOT_RUNNING", busy: false });
    offer("p1", 1, [["0", video]]);
    await pass(1);
    expect(peer().configuration.iceServers).toEqual([{ urls: ["stun:s"] }]);
  });

  it("answers the offer, then sends candidates, and shows the track at once", async () => {
    const tracks: unknown[] = [];
    video.on("track", (track) => tracks.push(track));
    await video.connect();
    offer("p1", 1, [["0", video]]);
    await pass(1);
    expect(gateway.called("signaling.answer")).toEqual([{ peer_id: "p1", generation: 1, sdp: "answer 1" }]);
    expect(gateway.called("signaling.candidate")).toEqual([
      { peer_id: "p1", generation: 1, candidate: "candidate:1", sdp_mid: "0", sdp_m_line_index: 0 },
    ]);
    expect(gateway.calls.at(-2)?.method).toBe("signaling.answer");
    expect(tracks).toEqual([video.track]);
    expect(peer().receivers.get("0")?.jitterBufferTarget).toBe(0);
    peer().onicecandidate?.({ candidate: null });
    await pass(1);
    expect(gateway.called("signaling.candidate")[1]).toEqual({
      peer_id: "p1",
      generation: 1,
      candidate: null,
      sdp_mid: null,
      sdp_m_line_index: null,
    });
    gateway.notify("signaling.candidate", { peer_id: "p1", generation: 1, candidate: "c", sdp_mid: "0" });
    gateway.notify("signaling.candidate", { peer_id: "p1", generation: 1, candidate: null });
    expect(peer().candidates).toEqual([{ candidate: "c", sdpMid: "0", sdpMLineIndex: null }, undefined]);
  });

  it("takes further streams of the engine into the same peer connection", async () => {
    await running();
    const audio = receiver.stream(AUDIO, "audio");
    await audio.connect();
    offer("p1", 2, [
      ["0", video],
      ["1", audio],
    ]);
    await pass(1);
    expect(FakePeerConnection.all).toHaveLength(1);
    expect(audio.track).toBe(peer().receivers.get("1")?.track);
    expect(receiver.stream(AUDIO, "audio")).toBe(audio);
  });

  it("tries again after a refusal, at growing distances and when the engines change", async () => {
    gateway.on("rois.stream.connect_stream", () => ({ return_code: "UNSUPPORTED" }));
    await video.connect();
    expect(video.problem).toEqual({ kind: "unsupported", detail: "UNSUPPORTED" });
    await pass(500);
    expect(gateway.called("rois.stream.connect_stream")).toHaveLength(2);
    await pass(740);
    expect(gateway.called("rois.stream.connect_stream")).toHaveLength(2);
    gateway.on("rois.stream.connect_stream", () => ({ stream_id: "avatar/s9" }));
    gateway.notify("rois.system.profile_changed", {});
    await pass(0);
    expect(video).toMatchObject({ streamId: "avatar/s9", problem: null });
  });

  it("tries again when its own engine has changed, of those that are named", async () => {
    gateway.on("rois.stream.connect_stream", () => ({ return_code: "UNSUPPORTED" }));
    await video.connect();
    const count = (): number => gateway.called("rois.stream.connect_stream").length;
    const before = count();
    gateway.notify("openrois.directory.changed", { changed: ["robot"], gone: ["avatar"] });
    await pass(0);
    expect(count()).toBe(before);
    gateway.notify("openrois.directory.changed", { changed: ["avatar"] });
    await pass(0);
    expect(count()).toBe(before + 1);
    gateway.notify("openrois.directory.changed", { changed: ["robot"], unnamed: 1 });
    await pass(0);
    expect(count()).toBe(before + 2);
  });

  it("passes on the engine's reason for a refusal", async () => {
    gateway.on("rois.stream.connect_stream", (_, id) => {
      gateway.notify("openrois.reason", { request_id: id, reason: "too many" });
      return { return_code: "OUT_OF_RESOURCES" };
    });
    await video.connect();
    expect(video.problem).toEqual({ kind: "refused", detail: "too many" });
  });

  it.each([
    ["no-streaming", new FakeGateway(null)],
    ["refused", new FakeGateway().on("rois.stream.connect_stream", () => ({ return_code: "ERROR" }))],
  ])("says %s", async (kind, other) => {
    const elsewhere = new Client("ws://test/", { webSocket: other.webSocket });
    await elsewhere.connect();
    const stream = new MediaReceiver(elsewhere, { codecs: () => [] }).stream(VIDEO, "video");
    await stream.connect();
    expect(stream.problem?.kind).toBe(kind);
  });

  it("gives up a stream for which no offer comes, and connects anew", async () => {
    await video.connect();
    await pass(20_000);
    expect(gateway.called("rois.stream.disconnect_stream")).toEqual([{ stream_id: "avatar/s1" }]);
    await pass(500);
    expect(video.streamId).toBe("avatar/s2");
  });

  it("says so when no offer and when no frame comes within 10 s", async () => {
    await video.connect();
    await pass(11_000);
    expect(video.problem).toEqual({ kind: "no-media", detail: "the engine made no offer" });
    offer("p1", 1, [["0", video]]);
    await pass(12_000);
    expect(video.problem).toEqual({ kind: "no-media", detail: "ICE new" });
    expect(gateway.called("signaling.restart")).toEqual([{ peer_id: "p1" }]);
    status(video, "STREAMING_RUNNING");
    await flow(2000);
    expect(video.problem).toBeNull();
  });
});

describe("suspend, resume, disconnect", () => {
  it("ask the engine, and show what it reports", async () => {
    await running();
    await video.suspend();
    expect(gateway.called("rois.stream.suspend_stream")).toEqual([{ stream_id: "avatar/s1" }]);
    status(video, "STREAMING_SUSPENDED");
    expect(video.status).toBe("STREAMING_SUSPENDED");
    await pass(60_000);
    expect(gateway.called("signaling.restart")).toEqual([]);
    await video.resume();
    status(video, "STREAMING_RESUMED");
    expect(video.status).toBe("STREAMING_RUNNING");
    const interrupted = vi.fn();
    video.on("interrupted", interrupted);
    await video.disconnect();
    expect(gateway.called("rois.stream.disconnect_stream")).toEqual([{ stream_id: "avatar/s1" }]);
    expect(interrupted).toHaveBeenCalledOnce();
    expect(video).toMatchObject({ streamId: null, status: "STREAMING_NOT_CONNECTED", track: null });
    await video.connect();
    expect(video.streamId).toBe("avatar/s2");
  });

  it("resume what the engine has suspended by itself, only when asked", async () => {
    await running();
    status(video, "STREAMING_SUSPENDED");
    await pass(1000);
    expect(gateway.called("rois.stream.resume_stream")).toEqual([]);
    await video.resume();
    expect(gateway.called("rois.stream.resume_stream")).toEqual([{ stream_id: "avatar/s1" }]);
  });

  it("wait for a stream that cannot be suspended before it runs", async () => {
    gateway.on("rois.stream.suspend_stream", () => ({ return_code: "ERROR" }));
    await video.connect();
    await video.suspend();
    gateway.on("rois.stream.suspend_stream", () => ({}));
    status(video, "STREAMING_RUNNING");
    await pass(0);
    expect(gateway.called("rois.stream.suspend_stream")).toHaveLength(2);
  });

  it("connect anew when the engine no longer knows the stream", async () => {
    await running();
    gateway.on("rois.stream.suspend_stream", () => ({ return_code: "UNSUPPORTED" }));
    await video.suspend();
    expect(video.status).toBe("STREAMING_NOT_CONNECTED");
    gateway.on("rois.stream.suspend_stream", () => ({}));
    await pass(500);
    expect(video.streamId).toBe("avatar/s2");
    expect(gateway.called("rois.stream.suspend_stream").at(-1)).toEqual({ stream_id: "avatar/s2" });
  });

  it("are not sent twice", async () => {
    const connecting = video.connect();
    video.retryNow();
    void video.connect();
    await connecting;
    await pass(0);
    expect(gateway.called("rois.stream.connect_stream")).toHaveLength(1);
  });

  it("may change their mind while a verb is under way", async () => {
    const connecting = video.connect();
    void video.disconnect();
    await connecting;
    expect(video.streamId).toBeNull();
    expect(gateway.called("rois.stream.disconnect_stream")).toEqual([{ stream_id: "avatar/s1" }]);
  });
});

describe("recovery", () => {
  it("connects again when the engine came back, with a new id", async () => {
    await running();
    status(video, "STREAMING_NOT_CONNECTED");
    gateway.on("rois.stream.connect_stream", () => ({ return_code: "UNSUPPORTED" }));
    await pass(5000);
    expect(video.problem?.kind).toBe("unsupported");
    gateway.on("rois.stream.connect_stream", () => ({ stream_id: "avatar/new" }));
    gateway.notify("rois.system.profile_changed", {});
    await pass(0);
    expect(video).toMatchObject({ streamId: "avatar/new", problem: null });
  });

  it.each(["suspended", "disconnected"] as const)("keeps a %s stream so", async (desire) => {
    await running();
    await (desire === "suspended" ? video.suspend() : video.disconnect());
    gateway.stop();
    gateway.running = true;
    await pass(2000);
    expect(client.state.name).toBe("connected");
    expect(video.streamId).toBe(desire === "suspended" ? "avatar/s2" : null);
    expect(gateway.called("rois.stream.suspend_stream")).toHaveLength(desire === "suspended" ? 2 : 0);
  });

  it("plays on without the gateway, and moves over when the first frame of the new session is there", async () => {
    await running();
    const [old] = FakePeerConnection.all;
    const tracks: unknown[] = [];
    video.on("track", (track) => tracks.push(track));
    gateway.socket.endSocket(1006);
    expect(video).toMatchObject({ streamId: null, status: null });
    expect(video.track).not.toBeNull();
    await flow(1000, old);
    const candidates = gateway.called("signaling.candidate").length;
    old?.onicecandidate?.({ candidate: { candidate: "late" } });
    expect(gateway.called("signaling.candidate")).toHaveLength(candidates);
    offer("p2", 1, [["0", video]]);
    await pass(500);
    expect(tracks).toEqual([]);
    expect(old?.connectionState).toBe("connected");
    await flow(500);
    expect(tracks).toEqual([peer().receivers.get("0")?.track]);
    await pass(150);
    expect(old?.connectionState).toBe("closed");
  });

  it("knows when a picture was captured, by the clock of the peer connection that brings it", async () => {
    const clock = { ssrc: 7, clock_rate: 90_000, rtp_origin: 0, wall: 5000 };
    const tell = (peer_id: string, mid: string, wall: number): void =>
      gateway.notify("signaling.capture_clocks", { peer_id, senders: [{ ...clock, mid, wall }] });
    await running();
    expect(video.capturedAt(90)).toBeNull();
    tell("p1", "1", 0);
    tell("p9", "0", 0);
    expect(video.capturedAt(90)).toBeNull();
    tell("p1", "0", 5000);
    expect(video.capturedAt(90)).toBe(5001);
    tell("p1", "0", 9000);
    expect(video.capturedAt(90)).toBe(9001);
    offer("p2", 1, [["0", video]], { replaces: "p1" });
    await pass(1);
    tell("p2", "0", 1000);
    expect(video.capturedAt(90)).toBe(9001);
    await flow(500);
    expect(video.capturedAt(90)).toBe(1001);
    gateway.socket.endSocket(1006);
    expect(video.capturedAt(90)).toBe(1001);
  });

  it("asks for another peer connection when frames stay away, and switches without a gap", async () => {
    await running();
    const old = peer();
    await pass(5000);
    expect(gateway.called("signaling.restart")).toEqual([{ peer_id: "p1" }]);
    offer("p2", 1, [["0", video]], { replaces: "p1" });
    await pass(200);
    expect(old.connectionState).toBe("connected");
    await flow(500);
    expect(video.track).toBe(peer().receivers.get("0")?.track);
    await pass(150);
    expect(old.connectionState).toBe("closed");
    expect(video.streamId).toBe("avatar/s1");
    gateway.notify("signaling.bye", { peer_id: "p1", reason: "replaced" });
    expect(video.streamId).toBe("avatar/s1");
  });

  it("looks for another way at once when the network has changed", async () => {
    await running();
    receiver.networkChanged();
    await pass(1);
    expect(gateway.called("signaling.restart")).toEqual([{ peer_id: "p1" }]);
    offer("p2", 1, [["0", video]], { replaces: "p1" });
    await pass(1);
    receiver.networkChanged();
    await pass(1);
    expect(gateway.called("signaling.restart")).toEqual([{ peer_id: "p1" }, { peer_id: "p2" }]);
  });

  it("keeps a stream whose old peer ends before the new one has a frame", async () => {
    await running();
    await pass(5000);
    offer("p2", 1, [["0", video]], { replaces: "p1" });
    await pass(1);
    gateway.notify("signaling.bye", { peer_id: "p1", reason: "replaced" });
    expect(video.streamId).toBe("avatar/s1");
    expect(video.track).toBe(peer().receivers.get("0")?.track);
  });

  it("says so when frames came before the engine was restarted, and none come now", async () => {
    await running();
    status(video, "STREAMING_NOT_CONNECTED");
    await pass(500);
    offer("p2", 1, [["0", video]]);
    await pass(12_000);
    expect(video.problem?.kind).toBe("no-media");
  });

  it("moves a suspended stream when the new path stands", async () => {
    await running();
    await video.suspend();
    status(video, "STREAMING_SUSPENDED");
    peer().become("failed");
    await pass(1);
    expect(gateway.called("signaling.restart")).toHaveLength(1);
    offer("p2", 1, [["0", video]], { replaces: "p1" });
    await pass(200);
    peer().become("connected");
    await pass(1);
    expect(video.track).toBe(peer().receivers.get("0")?.track);
  });

  it("starts from nothing when the engine does not know the peer any more", async () => {
    await running();
    gateway.on("signaling.restart", () => ({ return_code: "UNSUPPORTED" }));
    const interrupted = vi.fn();
    video.on("interrupted", interrupted);
    peer().become("failed");
    await pass(600);
    expect(interrupted).toHaveBeenCalledOnce();
    expect(peer().connectionState).toBe("closed");
    expect(video.streamId).toBe("avatar/s2");
  });

  it("loses with a bye what arrived by that peer", async () => {
    await running();
    gateway.notify("signaling.bye", { peer_id: "p1", reason: "no answer" });
    expect(video).toMatchObject({ streamId: null, status: "STREAMING_NOT_CONNECTED", track: null });
    await pass(500);
    expect(peer().connectionState).toBe("closed");
    expect(video.streamId).toBe("avatar/s2");
  });

  it("gives up a peer whose offer the browser refuses", async () => {
    const silent = vi.spyOn(console, "error").mockImplementation(() => undefined);
    FakePeerConnection.refuse = true;
    await video.connect();
    offer("p1", 1, [["0", video]]);
    await pass(150);
    expect(peer().connectionState).toBe("closed");
    expect(gateway.called("signaling.answer")).toEqual([]);
    expect(silent).toHaveBeenCalledOnce();
    silent.mockRestore();
  });

  it("reports a lack of offers also while an earlier picture is shown", async () => {
    await running();
    status(video, "STREAMING_NOT_CONNECTED");
    await pass(11_500);
    expect(video.track).not.toBeNull();
    expect(video.problem?.detail).toBe("the engine made no offer");
  });

  it("closes everything", async () => {
    await running();
    await receiver.close();
    await client.close();
    await pass(150);
    expect(vi.getTimerCount()).toBe(0);
    expect(peer().connectionState).toBe("closed");
    expect(video.streamId).toBeNull();
  });
});

it("gives figures once a second", async () => {
  const rates: number[] = [];
  video.on("figures", ({ rate }) => rates.push(Math.round(rate)));
  await running();
  await flow(3000);
  expect(rates.slice(-2)).toEqual([30, 30]);
});
