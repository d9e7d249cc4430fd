import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Teleoperation } from "../../sdk/input/teleoperation.ts";
import { MediaReceiver } from "../../sdk/media/receiver.ts";
import { Client } from "../../sdk/rois/client.ts";
import { FakeGateway } from "../support/fake_gateway.ts";
import { FakeElement, FakeDocument, FakeGamepad, happen } from "../support/fake_page.ts";
import { FakePeerConnection } from "../support/fake_peer_connection.ts";

const REF = "avatar/teleoperation";

type Message = Record<string, unknown>;

let gateway: FakeGateway;
let client: Client;
let teleoperation: Teleoperation;
let page: FakeDocument;
let element: FakeElement;
let pads: FakeGamepad[];
let connection: FakePeerConnection;
let events: string[];

const pass = (ms: number): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);
const sent = (label: string): Message[] =>
  connection.channel(label).sent.map((text) => JSON.parse(text) as Message);
const last = (label: string): Message | undefined => sent(label).at(-1);
const press = (code: string, fields: object = {}): Event => happen(element, "keydown", { code, ...fields });

beforeEach(async () => {
  vi.useFakeTimers();
  FakePeerConnection.all.length = 0;
  page = new FakeDocument();
  element = new FakeElement();
  pads = [];
  vi.stubGlobal("document", page);
  vi.stubGlobal("window", new EventTarget());
  vi.stubGlobal("navigator", { getGamepads: () => pads });
  gateway = new FakeGateway();
  gateway.on("rois.stream.connect_stream", () => ({ stream_id: "avatar/s1" }));
  for (const name of ["bind", "release", "execute"]) gateway.on(`rois.command.${name}`, () => ({}));
  gateway.on("signaling.answer", () => ({}));
  gateway.on("signaling.candidate", () => ({}));
  gateway.on("rois.query.query", () => ({
    results: [{ name: "operated", data_type_ref: "bool", value: "true" }],
  }));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  const media = new MediaReceiver(client, {
    input: true,
    codecs: () => ["video/x"],
    createPeerConnection: (configuration) =>
      new FakePeerConnection(configuration) as unknown as RTCPeerConnection,
  });
  await client.connect();
  await media.stream("avatar/video", "video").connect();
  const section = { mid: "0", stream_id: "avatar/s1", component_ref: "avatar/video", kind: "video" };
  gateway.notify("signaling.offer", {
    peer_id: "avatar/p1",
    generation: 1,
    sdp: "0 video,m=application 9",
    streams: [{ ...section, direction: "recvonly" }],
  });
  await pass(1);
  connection = FakePeerConnection.all[0] as FakePeerConnection;
  teleoperation = new Teleoperation(client, media, REF);
  events = [];
  for (const name of ["refused", "stopped", "ended"] as const)
    teleoperation.on(name, (reason) => events.push(`${name}: ${reason}`));
  teleoperation.attach(element as unknown as HTMLElement);
  await teleoperation.start();
});

afterEach(() => {
  teleoperation.detach();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

const asked = (method: string): Message[] =>
  gateway.calls.filter((each) => each.method === method).map(({ params }) => params as Message);

describe("Teleoperation", () => {
  it("asks for data channels with the stream, and has them as both ends agreed", () => {
    const [{ parameters }] = asked("rois.stream.connect_stream") as [{ parameters: { value: string }[] }];
    expect(JSON.parse(parameters[1]?.value ?? "")).toEqual({ direction: "recvonly", input: true });
    expect(connection.channel("input").options).toEqual({
      negotiated: true,
      id: 0,
      ordered: false,
      maxRetransmits: 0,
    });
    expect(connection.channel("control").options).toEqual({ negotiated: true, id: 1 });
    expect(teleoperation.linked).toBe(true);
  });

  it("binds the component and starts it", () => {
    expect(asked("rois.command.bind")).toEqual([{ component_ref: REF }]);
    expect(asked("rois.command.execute")).toHaveLength(1);
    expect(teleoperation.operating).toBe(true);
  });

  it("sends a key at once, and the held state again and again until its release", async () => {
    const event = press("KeyW");
    expect(event.defaultPrevented).toBe(true);
    expect(last("control")).toMatchObject({ event: "key", code: "KeyW", down: true });
    expect(last("input")).toMatchObject({ keys: ["KeyW"] });
    const before = sent("input").length;
    await pass(1000);
    expect(sent("input").length - before).toBeGreaterThanOrEqual(10);
    happen(window, "keyup", { code: "KeyW" });
    expect(last("control")).toMatchObject({ down: false });
    expect(last("input")).not.toHaveProperty("keys");
    const after = sent("input").length;
    await pass(1000);
    expect(sent("input").length).toBe(after);
  });

  it("leaves the page and the browser their own keys", () => {
    for (const code of ["Tab", "Escape", "F5"]) press(code);
    press("KeyR", { ctrlKey: true });
    expect(sent("control")).toEqual([]);
  });

  it("leaves the page the keys that it keeps for itself", () => {
    teleoperation.attach(element as unknown as HTMLElement, { pageKeys: (code) => code === "Digit1" });
    expect([press("Digit1").defaultPrevented, press("Digit2").defaultPrevented]).toEqual([false, true]);
    expect(sent("control").map(({ code }) => code)).toEqual([undefined, "Digit2"]);
  });

  it("sends where the pointer is, at most as often as pictures are shown", async () => {
    for (let x = 100; x <= 300; x += 1)
      happen(element, "pointermove", { pointerType: "mouse", clientX: x, clientY: 100, buttons: 0 });
    await pass(20);
    expect(sent("input").map(({ pointer }) => pointer)).toEqual([[1, 0.5, 0]]);
    happen(element, "pointerdown", {
      pointerType: "mouse",
      pointerId: 1,
      button: 0,
      buttons: 1,
      clientX: 100,
      clientY: 50,
    });
    expect(last("control")).toMatchObject({ event: "button", button: 0, down: true, x: 0, y: 0 });
    expect([element.focused, element.captured]).toEqual([1, [1]]);
    happen(window, "pointerup", { pointerType: "mouse", button: 0, buttons: 0, clientX: 500, clientY: 50 });
    expect(last("control")).toMatchObject({ event: "button", down: false, x: 1 });
    happen(window, "pointerup", { pointerType: "mouse", button: 0, buttons: 0, clientX: 500, clientY: 50 });
    expect(sent("control")).toHaveLength(2);
    happen(element, "wheel", { deltaX: 0, deltaY: 3, clientX: 200, clientY: 100 });
    expect(last("control")).toMatchObject({ event: "wheel", dy: 3, x: 0.5, y: 0.5 });
  });

  it("follows fingers", async () => {
    const at = { pointerType: "touch", pointerId: 4, clientX: 200, clientY: 100 };
    happen(element, "pointermove", at);
    happen(element, "pointerdown", at);
    happen(element, "pointermove", { ...at, clientX: 300 });
    await pass(20);
    expect(last("input")).toMatchObject({ touches: [[4, 1, 0.5]] });
    happen(window, "pointercancel", at);
    expect(sent("control").map(({ down }) => down)).toEqual([true, false]);
  });

  it("captures the mouse if that is wanted, and adds its movements up", async () => {
    teleoperation.attach(element as unknown as HTMLElement, { pointerLock: true });
    const click = { pointerType: "mouse", pointerId: 1, button: 0, buttons: 1, clientX: 200, clientY: 100 };
    happen(element, "pointerdown", click);
    expect(element.locked).toBe(1);
    page.pointerLockElement = element;
    for (const movementX of [50, 500])
      happen(element, "pointermove", { pointerType: "mouse", movementX, movementY: -10, buttons: 0 });
    await pass(20);
    expect(last("input")).toMatchObject({ pointer: [1, 0.3, 0] });
    teleoperation.detach();
    expect(page.pointerLockElement).toBeNull();
  });

  it("reads the gamepad of the standard mapping while the page has the focus", async () => {
    const strange = new FakeGamepad();
    strange.mapping = "";
    strange.axes = [1, 1, 1, 1];
    const pad = new FakeGamepad();
    pads = [strange, pad];
    pad.axes = [0, -0.75, 0, 0];
    pad.buttons[3] = { value: 1 };
    await pass(20);
    expect(last("input")).toMatchObject({ gamepad: { axes: [0, -0.75, 0, 0] } });
    expect(last("control")).toMatchObject({ event: "pad", button: 3, down: true });
    page.focused = false;
    await pass(20);
    expect(last("input")).not.toHaveProperty("gamepad");
  });

  it.each([
    ["blur", () => happen(element, "blur")],
    ["blur", () => happen(window, "blur")],
    ["hidden", () => happen(window, "pagehide")],
    ["hidden", () => (page.visibilityState = "hidden") && happen(page, "visibilitychange")],
    ["bye", () => teleoperation.detach()],
  ])("releases everything: %s", async (why, leave) => {
    press("KeyW");
    leave();
    expect(last("control")).toMatchObject({ event: "release", why });
    expect(last("input")).not.toHaveProperty("keys");
    const count = sent("input").length;
    await pass(1000);
    expect(sent("input")).toHaveLength(count);
  });

  it("adds nothing to what waits to be sent, and sends the newest when there is room", async () => {
    connection.channel("input").bufferedAmount = 5000;
    press("KeyW");
    press("KeyA");
    await pass(500);
    expect(sent("input")).toEqual([]);
    connection.channel("input").bufferedAmount = 0;
    await pass(20);
    expect(sent("input")).toHaveLength(1);
    expect(last("input")).toMatchObject({ keys: ["KeyW", "KeyA"] });
  });

  it("passes on why it is refused or stopped", () => {
    press("KeyW");
    connection.channel("control").onmessage?.({ data: '{"event":"stopped","reason":"no input"}' });
    connection.channel("control").onmessage?.({ data: "nonsense" });
    expect(events).toEqual(["stopped: no input"]);
  });

  it("sends nothing when its operation has ended, and passes on why", async () => {
    const { command_unit_list: units } = asked("rois.command.execute")[0] as {
      command_unit_list: { command_id: string }[];
    };
    gateway.notify("rois.command.completed", { command_id: units[0]?.command_id ?? "", status: "ABORT" });
    await pass(1);
    expect([teleoperation.operating, events]).toEqual([false, ["ended: ABORT"]]);
    expect(asked("rois.command.release")).toEqual([{ component_ref: REF }]);
    press("KeyW");
    await pass(500);
    expect(sent("input")).toEqual([]);
  });

  it("sends nothing more of what is held when the body is stopped", async () => {
    gateway.on("openrois.stop_all", () => ({ stopped: [] }));
    press("KeyW");
    const pad = new FakeGamepad();
    pad.axes = [0, -1, 0, 0];
    pads = [pad];
    await pass(20);
    await client.control.stopAll("other");
    expect(last("input")).toMatchObject({ keys: ["KeyW"] });
    const stopping = client.control.stopAll("avatar");
    expect(last("control")).toMatchObject({ event: "release" });
    press("KeyW", { repeat: true });
    await pass(500);
    expect(last("input")).not.toHaveProperty("gamepad.axes");
    expect(last("input")).not.toHaveProperty("keys");
    await stopping;
    press("KeyW");
    expect(last("input")).toMatchObject({ keys: ["KeyW"] });
  });

  it("does not begin when the body is stopped while it is being bound", async () => {
    gateway.on("openrois.stop_all", () => ({ stopped: [] }));
    await teleoperation.stop();
    const before = asked("rois.command.execute").length;
    const starting = teleoperation.start();
    await client.control.stopAll("avatar");
    await expect(starting).rejects.toMatchObject({ status: "ABORT" });
    expect([teleoperation.operating, asked("rois.command.execute").length]).toEqual([false, before]);
    expect(asked("rois.command.release")).toHaveLength(2);
  });

  it("stops, and gives the component back", async () => {
    press("KeyW");
    await teleoperation.stop();
    await teleoperation.stop();
    expect(last("control")).toMatchObject({ event: "release", why: "bye" });
    expect(asked("rois.command.release")).toEqual([{ component_ref: REF }]);
    expect([teleoperation.operating, events]).toEqual([false, []]);
  });
});
