import { beforeEach, describe, expect, it } from "vitest";
import { packFrame, pcm16, readSpeechTold } from "../../sdk/input/speech_messages.ts";
import { SpeechStream } from "../../sdk/input/speech_stream.ts";
import { InputChannels } from "../../sdk/input/channels.ts";
import { Client } from "../../sdk/rois/client.ts";
import { FakeGateway } from "../support/fake_gateway.ts";
import { FakePeerConnection } from "../support/fake_peer_connection.ts";

const REF = "avatar/speech_stream";

let gateway: FakeGateway;
let client: Client;
let open: InputChannels[];
let connection: FakePeerConnection;
let speech: SpeechStream;
let steps: unknown[];

const sent = (label = "speech"): Record<string, unknown>[] =>
  connection.channel(label).sent.map((text) => JSON.parse(text) as Record<string, unknown>);
const tell = (told: object): void =>
  connection.channel("speech").onmessage?.({ data: JSON.stringify(told) }) as undefined;
const number = (): number => sent().at(-1)?.["utterance"] as number;
const samples = (): number =>
  connection.channel("speech").frames.reduce((sum, frame) => sum + (frame.byteLength - 8) / 2, 0);
const settle = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));

beforeEach(async () => {
  gateway = new FakeGateway();
  for (const name of ["bind", "release"]) gateway.on(`rois.command.${name}`, () => ({}));
  gateway.on("rois.query.query", () => ({ results: [] }));
  gateway.on("openrois.stop_all", () => ({ stopped: [] }));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  connection = new FakePeerConnection({});
  open = [new InputChannels(connection as unknown as RTCPeerConnection)];
  speech = new SpeechStream(client, { inputs: () => open.filter((each) => each.open) }, REF, 16_000);
  steps = [];
  for (const name of ["started", "starved", "finished"] as const)
    speech.on(name, (value) => steps.push([name, value]));
  await speech.start();
});

describe("SpeechStream", () => {
  it("binds the component, and asks it something behind that", () => {
    const methods = gateway.calls.map(({ method }) => method);
    expect(methods.indexOf("rois.query.query")).toBeGreaterThan(methods.indexOf("rois.command.bind"));
    expect(connection.channel("speech").options).toEqual({ negotiated: true, id: 2 });
  });

  it("begins with the first push, sends a second at once, and more as it is played", async () => {
    let pushed = false;
    const pushing = speech.push(new Int16Array(20_000), "Hello").then(() => (pushed = true));
    await settle();
    expect(sent()).toEqual([
      { event: "begin", utterance: number(), format: "pcm16", rate: 16_000, text: "Hello" },
    ]);
    expect([samples() <= 16_000, samples() > 13_900, pushed]).toEqual([true, true, false]);
    tell({ event: "credit", utterance: number(), samples: 22_000, played: 6_000 });
    await pushing;
    expect(samples()).toBe(20_000);
    const sequences = connection.channel("speech").frames.map((frame) => new DataView(frame).getUint32(4));
    expect(sequences).toEqual(sequences.map((_, index) => index));
  });

  it("tells what becomes of it, and a next one begins behind it", async () => {
    await speech.push(new Float32Array(10));
    const first = number();
    speech.addWords([["Hello", 0.25]]);
    const finishing = speech.finish();
    await settle();
    expect(sent().slice(1)).toEqual([
      { event: "words", utterance: first, words: [["Hello", 250]] },
      { event: "end", utterance: first },
    ]);
    tell({ event: "started", utterance: first, speech_id: "s1" });
    tell({ event: "starved", utterance: first, position: 500 });
    await speech.push(new Float32Array(10));
    expect(number()).toBe(first + 1);
    tell({ event: "finished", utterance: first, position: 500 });
    expect(await finishing).toEqual({ seconds: 0.5, reason: "" });
    expect(steps).toEqual([
      ["started", "s1"],
      ["starved", 0.5],
      ["finished", { seconds: 0.5, reason: "" }],
    ]);
    expect(await new SpeechStream({} as Client, { inputs: () => [] }, REF).finish()).toEqual({
      seconds: 0,
      reason: "",
    });
  });

  it("clears past the sound, and says what was heard", async () => {
    await speech.push(new Int16Array(8_000));
    const clearing = speech.clear();
    expect(sent("control")).toEqual([{ event: "clear", utterance: number() }]);
    tell({ event: "finished", utterance: number(), position: 120, reason: "the speech was cleared" });
    expect(await clearing).toEqual({ seconds: 0.12, reason: "the speech was cleared" });
  });

  it.each([
    ["clears", () => speech.clear(), "the speech was cleared"],
    ["is stopped with its body", () => client.control.stopAll("avatar"), "avatar was stopped by ann"],
  ])("speaks nothing of what waits behind others when it %s", async (_, silence, reason) => {
    const waiting = [1, 2, 3].map(() => speech.push(new Int16Array(20_000)));
    const [first, ...others] = waiting.map((push) => push.then(null, ({ message }: Error) => message));
    await settle();
    const [utterance, before] = [number(), samples()];
    const silenced = silence();
    expect(sent("control")).toEqual([{ event: "clear", utterance }]);
    tell({ event: "finished", utterance, position: 120, reason });
    await silenced;
    expect(await first).toBe(reason);
    for (const other of others) expect(await other).toBe("the speech was cleared before this was spoken");
    expect([samples(), sent().filter(({ event }) => event === "begin").length]).toEqual([before, 1]);
    await speech.push(new Int16Array(8));
    expect(number()).toBe(utterance + 1);
  });

  it("drops what waits with the speech that is interrupted, and not the next one", async () => {
    const end = ({ message }: Error): string => message;
    const waiting = [1, 2].map(() => speech.push(new Int16Array(20_000)).then(() => "", end));
    const finished = speech.finish();
    const next = speech.push(new Int16Array(8));
    await settle();
    const utterance = number();
    tell({ event: "finished", utterance, position: 120, reason: "the voice is held by bob" });
    expect(await Promise.all(waiting)).toEqual(Array(2).fill("the voice is held by bob"));
    await Promise.all([finished, next]);
    expect(number()).toBe(utterance + 1);
    await speech.push(new Int16Array(8));
    expect(number()).toBe(utterance + 1);
  });

  it("is not begun when its body is stopped while it is being bound", async () => {
    const starting = new SpeechStream(client, { inputs: () => [] }, REF).start();
    await client.control.stopAll("avatar");
    await expect(starting).rejects.toMatchObject({ status: "ABORT" });
    expect(gateway.calls.at(-1)?.method).toBe("rois.command.release");
  });

  it("fails a push that waits when the speech is interrupted, refused, or lost with its channels", async () => {
    for (const [end, reason] of [
      [() => tell({ event: "refused", utterance: number(), reason: "not bound" }), "not bound"],
      [() => connection.channel("speech").close(), "the connection over which it was spoken was lost"],
    ] as const) {
      const pushing = speech.push(new Int16Array(20_000));
      await settle();
      end();
      await expect(pushing).rejects.toThrow(reason);
    }
    await expect(speech.push(new Int16Array(1))).rejects.toThrow(
      "there is no connection to avatar/speech_stream now",
    );
  });

  it("clears what was lost with its channels over the next ones, so that the body waits for no more of it", async () => {
    const pushing = speech.push(new Int16Array(20_000));
    await settle();
    const lost = number();
    connection.channel("speech").close();
    await expect(pushing).rejects.toThrow("was lost");
    connection = new FakePeerConnection({});
    open = [new InputChannels(connection as unknown as RTCPeerConnection)];
    await speech.push(new Int16Array(8));
    expect(sent("control")).toEqual([{ event: "clear", utterance: lost }]);
    expect(number()).toBe(lost + 1);
    const finishing = speech.finish();
    await settle();
    tell({ event: "finished", utterance: number(), position: 0 });
    await finishing;
    await speech.push(new Int16Array(8));
    expect(sent("control")).toHaveLength(1);
  });

  it("gives the component back when it stops", async () => {
    await speech.stop();
    expect(gateway.calls.at(-1)?.method).toBe("rois.command.release");
  });
});

describe("Frames of speech", () => {
  it("are laid out as the page says", () => {
    expect([...new Uint8Array(packFrame(0x01020304, 5, Int16Array.of(0x2010, -2)))]).toEqual([
      1, 2, 3, 4, 0, 0, 0, 5, 0x10, 0x20, 0xfe, 0xff,
    ]);
  });

  it("take floats from -1 to 1", () => {
    expect([...pcm16(Float32Array.of(0, 1, -1, 7))]).toEqual([0, 32_767, -32_767, 32_767]);
  });

  it("leave out what the body tells and this end does not know", () => {
    expect(readSpeechTold("{")).toBeNull();
    expect(readSpeechTold('{"event": "applause", "utterance": 1}')).toBeNull();
    expect(readSpeechTold('{"event": "starved", "utterance": "1"}')).toBeNull();
  });
});
