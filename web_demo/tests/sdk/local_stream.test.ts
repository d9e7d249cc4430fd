import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { LocalStream } from "../../sdk/media/local_stream.ts";
import { MediaReceiver } from "../../sdk/media/receiver.ts";
import { Client } from "../../sdk/rois/client.ts";
import { FakeDevices } from "../support/fake_devices.ts";
import { FakeGateway } from "../support/fake_gateway.ts";
import { FakePeerConnection } from "../support/fake_peer_connection.ts";

const AUDIO = "avatar/audio";
const STEADY = { first: 500, factor: 1.5, random: (): number => 1 };

let gateway: FakeGateway;
let client: Client;
let receiver: MediaReceiver;
let fake: FakeDevices;
let microphone: LocalStream;

const pass = (ms: number): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);

const section = (index = -1): ReturnType<FakePeerConnection["section"]> => {
  const connection = FakePeerConnection.all.at(index);
  if (!connection) throw new Error("no peer connection was made");
  return connection.section("0");
};

const status = (value: string): void =>
  gateway.notify("rois.stream.notify_stream_status", {
    stream_id: microphone.streamId ?? "",
    component_ref: AUDIO,
    status: value,
    timestamp: "",
  });

async function offered(peer_id = "p1", generation = 1, replaces?: string): Promise<void> {
  const { streamId, direction } = microphone;
  const stream = { mid: "0", stream_id: streamId ?? "", component_ref: AUDIO, kind: "audio", direction };
  const streams = streamId === null ? [] : [stream];
  gateway.notify("signaling.offer", {
    peer_id,
    generation,
    sdp: "0 audio",
    streams,
    ...(replaces !== undefined && { replaces }),
  });
  await pass(1);
}

async function sending(): Promise<void> {
  await microphone.connect();
  await offered();
  FakePeerConnection.all.at(-1)?.become("connected");
  status("STREAMING_RUNNING");
  await flow(1000);
}

async function flow(ms: number): Promise<void> {
  for (let passed = 0; passed < ms; passed += 500) {
    section().sender.units += 25;
    await pass(500);
  }
}

beforeEach(async () => {
  vi.useFakeTimers();
  FakePeerConnection.all.length = 0;
  let count = 0;
  gateway = new FakeGateway();
  gateway.on("rois.stream.connect_stream", () => ({ stream_id: `avatar/s${++count}` }));
  for (const verb of ["disconnect", "suspend", "resume"])
    gateway.on(`rois.stream.${verb}_stream`, () => ({}));
  for (const method of ["answer", "candidate", "restart"]) gateway.on(`signaling.${method}`, () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: STEADY });
  fake = new FakeDevices();
  receiver = new MediaReceiver(client, {
    backoff: STEADY,
    codecs: (kind) => [`${kind}/x`],
    devices: fake.devices,
    createPeerConnection: (configuration) =>
      new FakePeerConnection(configuration) as unknown as RTCPeerConnection,
  });
  microphone = receiver.sending(AUDIO, "audio");
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
});

describe("a local stream", () => {
  it("says what it may be used for before it sends, anew when that changes, and again when it is connected again", async () => {
    gateway.on("rois.stream.set_consent", () => ({ visitor_ref: "urn:me" }));
    await microphone.setConsent(["live"]);
    expect(gateway.called("rois.stream.set_consent")).toEqual([]);
    await microphone.connect();
    await microphone.setConsent(["live", "agent"]);
    await microphone.setConsent([]);
    const id = microphone.streamId;
    expect(gateway.called("rois.stream.set_consent")).toEqual([
      { stream_id: id, consent: ["live", "agent"] },
      { stream_id: id, consent: [] },
    ]);
    expect([microphone.consent, microphone.visitorRef]).toEqual([[], "urn:me"]);
    status("STREAMING_NOT_CONNECTED");
    await pass(1000);
    const stated = gateway
      .called("rois.stream.connect_stream")
      .map((params) => (params as { parameters: { value: string }[] }).parameters[1]?.value);
    expect(stated).toEqual([
      '{"direction":"sendonly","consent":["live"]}',
      '{"direction":"sendonly","consent":[]}',
    ]);
  });

  it("says what it may be used for again where that was said while it was being connected", async () => {
    const answers: (() => void)[] = [];
    gateway.on("rois.stream.connect_stream", async () => {
      await new Promise<void>((resolve) => answers.push(resolve));
      return { stream_id: "avatar/late" };
    });
    gateway.on("rois.stream.set_consent", () => ({ visitor_ref: "urn:me" }));
    await microphone.setConsent(["live"]);
    const connecting = microphone.connect();
    await pass(1);
    await microphone.setConsent([]);
    expect(gateway.called("rois.stream.set_consent")).toEqual([]);
    answers.shift()?.();
    await connecting;
    expect(gateway.called("rois.stream.set_consent")).toEqual([{ stream_id: "avatar/late", consent: [] }]);
    expect(microphone.streamId).toBe("avatar/late");
  });

  it("sends nothing until the body knows what it may be used for, also where it cannot be told", async () => {
    let answer: ((result: { visitor_ref: string }) => void) | undefined;
    gateway.on(
      "rois.stream.set_consent",
      () => new Promise<{ visitor_ref: string }>((resolve) => (answer = resolve)),
    );
    await sending();
    expect(section().sender.track).toBe(fake.last);
    const stating = microphone.setConsent(["live"]);
    await pass(1);
    expect(section().sender.track).toBeNull();
    answer?.({ visitor_ref: "urn:me" });
    await stating;
    await pass(1);
    expect(section().sender.track).toBe(fake.last);
    gateway.on("rois.stream.set_consent", () => ({ return_code: "ERROR" }));
    await expect(microphone.setConsent([])).rejects.toThrow();
    await pass(1);
    expect(section().sender.track).toBeNull();
  });

  it("is made with what it may be used for", async () => {
    const camera = receiver.sending("avatar/video", "video", { consent: ["recognition"] });
    expect(camera.consent).toEqual(["recognition"]);
    expect(microphone.consent).toBeNull();
  });

  it("asks for the device, then the engine, and sends where the engine offers it", async () => {
    await microphone.connect();
    expect(fake.asked).toHaveLength(1);
    expect(gateway.called("rois.stream.connect_stream")).toEqual([
      {
        component_ref: AUDIO,
        parameters: [
          { name: "encoding_parameters", data_type_ref: "string", value: '{"codecs":["audio/x"]}' },
          { name: "transport_parameters", data_type_ref: "string", value: '{"direction":"sendonly"}' },
        ],
      },
    ]);
    const tracks = vi.fn();
    microphone.on("track", tracks);
    await offered();
    expect(section()).toMatchObject({ direction: "sendonly", sender: { track: fake.last } });
    expect(section().receiver.jitterBufferTarget).toBeNull();
    expect(gateway.called("signaling.answer")).toHaveLength(1);
    expect(microphone).toMatchObject({ track: null, captured: fake.last });
    expect(tracks).not.toHaveBeenCalled();
  });

  it("connects nothing without a device, and says why", async () => {
    fake.error = "NotAllowedError";
    await microphone.connect();
    expect(gateway.called("rois.stream.connect_stream")).toEqual([]);
    expect(microphone).toMatchObject({ desire: "disconnected", captureProblem: { kind: "refused" } });
  });

  it("keeps to its limits", async () => {
    const limits = { max_bitrate: 300_000, width: 320, fps: 15 };
    const camera = receiver.sending("avatar/video", "video", { limits });
    expect(receiver.sending("avatar/video", "video")).toBe(camera);
    await camera.connect();
    expect(fake.asked[0]?.video).toMatchObject({ width: { ideal: 320 }, frameRate: { ideal: 15 } });
    const [asked] = gateway.called("rois.stream.connect_stream") as [{ parameters: { value: string }[] }];
    expect(JSON.parse(asked.parameters[0]?.value ?? "")).toEqual({ codecs: ["video/x"], ...limits });
    const stream = { mid: "0", stream_id: camera.streamId ?? "", component_ref: "", kind: "video" };
    const streams = [{ ...stream, direction: "sendonly" }];
    gateway.notify("signaling.offer", { peer_id: "p1", generation: 1, sdp: "0 video", streams });
    await pass(1);
    expect(section().sender.encodings).toEqual([{ maxBitrate: 300_000, maxFramerate: 15 }]);
  });

  it("may go both ways", async () => {
    microphone = receiver.sending("avatar/both", "audio", { direction: "sendrecv" });
    await microphone.connect();
    await offered();
    expect(section()).toMatchObject({ direction: "sendrecv", sender: { track: fake.last } });
    expect(microphone.track).toBe(section().receiver.track);
  });

  it("gives figures of what is sent", async () => {
    const rates: number[] = [];
    microphone.on("figures", ({ rate }) => rates.push(Math.round(rate)));
    await sending();
    await flow(2000);
    expect(rates.at(-1)).toBe(50);
  });
});

describe("suspending and disconnecting", () => {
  it("stop sending at once, without the engine's answer", async () => {
    await sending();
    gateway.on("rois.stream.suspend_stream", () => ({ return_code: "ERROR" }));
    void microphone.suspend();
    expect(fake.last.enabled).toBe(false);
    expect(section().sender.track).toBeNull();
    gateway.on("rois.stream.suspend_stream", () => ({}));
    await pass(1000);
    void microphone.resume();
    expect(fake.last.enabled).toBe(true);
    expect(section().sender.track).toBe(fake.last);
    const disconnected = microphone.disconnect();
    expect(fake.last.stopped).toBe(true);
    await disconnected;
    expect(gateway.called("rois.stream.disconnect_stream")).toEqual([{ stream_id: "avatar/s1" }]);
    await offered("p1", 2);
    expect(section().sender.track).toBeNull();
  });

  it("wait for the engine that has suspended the stream by itself", async () => {
    await sending();
    status("STREAMING_SUSPENDED");
    await pass(1);
    expect(section().sender.track).toBeNull();
    expect(fake.last.enabled).toBe(true);
    status("STREAMING_NOT_RUNNING");
    await pass(1);
    expect(section().sender.track).toBe(fake.last);
    status("STREAMING_SUSPENDED");
    void microphone.resume();
    expect(section().sender.track).toBe(fake.last);
  });
});

describe("devices", () => {
  it("are changed without the engine", async () => {
    await sending();
    await microphone.use("d1");
    await pass(1);
    expect(section().sender.track).toBe(fake.last);
    expect(microphone.deviceId).toBe("d1");
    expect(gateway.called("rois.stream.connect_stream")).toHaveLength(1);
    expect(await microphone.devices()).toHaveLength(2);
  });

  it("that are lost are reported, and the stream goes on with the next one", async () => {
    await sending();
    fake.last.onended?.();
    await pass(1);
    expect(section().sender.track).toBeNull();
    expect(microphone.captureProblem?.kind).toBe("lost");
    await pass(30_000);
    expect(gateway.called("signaling.restart")).toEqual([]);
    await microphone.connect();
    await pass(1);
    expect(section().sender.track).toBe(fake.last);
    expect(microphone.captureProblem).toBeNull();
  });
});

describe("recovery", () => {
  it("connects again with the same device, without asking the user", async () => {
    await sending();
    status("STREAMING_NOT_CONNECTED");
    await pass(500);
    expect(microphone.streamId).toBe("avatar/s2");
    await offered("p2");
    expect(section().sender.track).toBe(fake.last);
    expect(fake.asked).toHaveLength(1);
  });

  it("sends over the next peer connection beside the old one", async () => {
    await sending();
    await offered("p2", 1, "p1");
    expect(section().sender.track).toBe(fake.last);
    expect(section(0).sender.track).toBe(fake.last);
    await flow(500);
    await pass(150);
    expect(FakePeerConnection.all[0]?.connectionState).toBe("closed");
  });

  it("releases the device when all is closed", async () => {
    await sending();
    await receiver.close();
    expect(fake.last.stopped).toBe(true);
  });

  it("sends silence while it is muted, whatever becomes of the stream", async () => {
    await sending();
    microphone.muted = true;
    expect(microphone.captured?.enabled).toBe(false);
    status("STREAMING_RUNNING");
    await pass(1);
    expect([microphone.captured?.enabled, microphone.desire]).toEqual([false, "running"]);
    microphone.muted = false;
    expect(microphone.captured?.enabled).toBe(true);
  });
});
