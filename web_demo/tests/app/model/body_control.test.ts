import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { BodyControl, BodyTaken } from "../../../app/model/body_control.ts";
import type { JsonObject } from "../../../sdk/jsonrpc/peer.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

const OPERATED = "a/teleoperation";
const BODY = [OPERATED, "a/navigation", "a/reaction"];
/** The components that represent a part each. */
const HEADS = [OPERATED, "a/reaction"];
const partOf = (ref: string): string => (ref === "a/reaction" ? "gesture" : "legs");

let gateway: FakeGateway;
let client: Client;
let body: BodyControl;
let lost: string[];
/** Who else holds what. */
let held: Map<string, string>;
/** Where in line this application stands for them. */
let position: number;
/** The visitor uses the page. */
let used: boolean;

const refOf = ({ component_ref: ref }: JsonObject): string => String(ref);
const holderOf = (ref: string): string | undefined =>
  [...held].find(([each]) => partOf(each) === partOf(ref))?.[1];
const verbs = (): string[] =>
  gateway.calls
    .filter(({ method }) => /bind$|release$|grant$|decline$|borrow$|give_back$|lease.request$/.test(method))
    .map(({ method, params }) => `${method.split(".").at(-1)} ${params["component_ref"] ?? "-"}`);
const tell = (name: string, params: JsonObject): void =>
  gateway.notify(`openrois.lease.${name}`, {
    ...(name === "changed" && { part: partOf(refOf(params)) }),
    ...params,
  });
const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(50);

beforeEach(async () => {
  vi.useFakeTimers();
  held = new Map();
  lost = [];
  position = 0;
  used = true;
  gateway = new FakeGateway(["openrois.lease"])
    .on("openrois.lease.token", () => ({ token: "t", grace_ms: 10_000 }))
    .on("openrois.lease.query", (params) => {
      const ref = refOf(params);
      const holder = holderOf(ref);
      const lease = holder === undefined ? { state: "FREE" } : { state: "HELD", holder, position };
      return { lease: { ...lease, part: partOf(ref) } };
    })
    .on("openrois.lease.request", () => ({ lease: { state: "HELD", position: 1 }, request_id: "r" }))
    .on("openrois.lease.grant", () => ({}))
    .on("openrois.lease.decline", () => ({}))
    .on("rois.command.bind", (params) => (holderOf(refOf(params)) ? { return_code: "OUT_OF_RESOURCES" } : {}))
    .on("rois.command.release", () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  body = new BodyControl(
    client,
    () => undefined,
    () => used,
  );
  body.onLost = (why) => void lost.push(why);
  body.setComponents(BODY);
  await settle();
});

afterEach(() => {
  vi.useRealTimers();
});

it("takes all parts once for several works, and gives them back with the last one, the operated one last", async () => {
  const [first, second] = await Promise.all([body.takeControl(), body.takeControl()]);
  expect(body.state).toEqual({ kind: "mine", lender: "" });
  expect(verbs()).toEqual(HEADS.map((ref) => `bind ${ref}`));
  first();
  first();
  await settle();
  expect(verbs()).toHaveLength(2);
  second();
  await settle();
  expect(verbs().slice(2)).toEqual([...HEADS].reverse().map((ref) => `release ${ref}`));
  expect(body.state).toEqual({ kind: "free" });
});

it("gives back what it was granted when one part is another's", async () => {
  held.set("a/reaction", "anna");
  body.setComponents(BODY);
  await settle();
  await expect(body.takeControl()).rejects.toBeInstanceOf(BodyTaken);
  await expect(body.takeControl()).rejects.toThrow("anna has control. Ask for it first.");
  expect(
    verbs()
      .filter((verb) => verb.startsWith("release"))
      .slice(0, 2),
  ).toEqual([...HEADS].reverse().map((ref) => `release ${ref}`));
  expect(body.state).toMatchObject({ kind: "other", holder: "anna" });
  expect([body.holderOf("a/reaction"), body.holderOf("a/navigation")]).toEqual(["anna", ""]);
});

it("names who has control, and without tokens says that there is one", async () => {
  tell("changed", { component_ref: OPERATED, state: "HELD", holder: "ben", reason: "it was free" });
  await settle();
  expect(body.state).toEqual({ kind: "other", holder: "ben", absent: false, mayTakeOver: false });
  expect(body.holderOf("a/navigation")).toBe("ben");
  tell("changed", { component_ref: OPERATED, state: "ABSENT", holder: "local", reason: "" });
  await settle();
  expect([body.holderOf(OPERATED), body.holderOf("a/reaction"), body.holderOf(null)]).toEqual([
    "Another visitor",
    "",
    "",
  ]);
  body.setComponents(null);
  expect([body.state.kind, body.holderOf(OPERATED)]).toEqual(["free", ""]);
});

it("lets go of everything when another application is given a part", async () => {
  const giveBack = await body.takeControl();
  tell("changed", { component_ref: "a/navigation", state: "HELD", holder: "root", reason: "" });
  await settle();
  expect(lost).toEqual(["root has control now."]);
  expect(verbs()).toContain(`release ${OPERATED}`);
  const count = verbs().length;
  giveBack();
  await settle();
  expect(verbs()).toHaveLength(count);
});

it("hands over the whole body: all else is given back before the part that was asked for is granted", async () => {
  await body.takeControl();
  tell("requested", { component_ref: OPERATED, request_id: "r1", subject: "ben", answer_ms: 30_000 });
  tell("requested", { component_ref: OPERATED, request_id: "r2", subject: "local", answer_ms: 30_000 });
  await settle();
  expect(body.nextRequest).toEqual({ subject: "ben", more: 1 });
  await body.answerRequest(false);
  expect(gateway.called("openrois.lease.decline")).toEqual([{ request_id: "r1" }]);
  expect(body.nextRequest).toEqual({ subject: "Another visitor", more: 0 });
  await body.answerRequest(true);
  await settle();
  expect(gateway.called("openrois.lease.grant")).toEqual([{ request_id: "r2" }]);
  expect(verbs().slice(3, 5)).toEqual(["release a/reaction", "grant -"]);
  expect(lost).toEqual(["You have handed over control to another visitor."]);
});

it("waits in line for what is another's, and has all of it or nothing then", async () => {
  held.set(OPERATED, "anna");
  body.setComponents(BODY);
  await settle();
  const granted = body.requestControl();
  position = 2;
  await settle();
  tell("changed", { component_ref: OPERATED, state: "HELD", holder: "anna", position: 2, reason: "" });
  tell("declined", { component_ref: OPERATED, request_id: "r", reason: "its holder keeps it" });
  await settle();
  expect(body.state).toEqual({ kind: "waiting", holder: "anna", position: 2, declined: true });
  held.delete(OPERATED);
  tell("changed", { component_ref: OPERATED, state: "MINE", position: 0, reason: "" });
  const giveBack = await granted;
  expect(body.state).toEqual({ kind: "mine", lender: "" });
  expect(verbs()).toEqual([
    `bind ${OPERATED}`,
    `release ${OPERATED}`,
    `request ${OPERATED}`,
    ...HEADS.map((ref) => `bind ${ref}`),
  ]);
  giveBack();
  await settle();
  expect(verbs().slice(-2)).toEqual([...HEADS].reverse().map((ref) => `release ${ref}`));
});

it("holds nothing when the body is stopped while it is being taken, and tells how often it was", async () => {
  gateway.on("openrois.stop_all", () => ({ stopped: [] }));
  body.setComponents(BODY);
  await settle();
  const taken = body.takeControl();
  const refused = expect(taken).rejects.toMatchObject({ status: "ABORT" });
  await client.control.stopAll("a");
  await client.control.stopAll("b");
  await refused;
  await settle();
  expect([body.state, body.stops]).toEqual([{ kind: "free" }, 1]);
  const bound = (verb: string): number => verbs().filter((each) => each.startsWith(`${verb} `)).length;
  expect(bound("release")).toBe(bound("bind"));
  await body.takeControl();
  expect(body.state).toEqual({ kind: "mine", lender: "" });
});

it("shows the answer to asking again, also where an older one comes later", async () => {
  held.set(OPERATED, "anna");
  body.setComponents(BODY);
  await settle();
  const granted = body.requestControl();
  granted.catch(() => undefined);
  await settle();
  const answers: ((position: number) => void)[] = [];
  gateway.on("openrois.lease.query", async () => {
    const place = await new Promise<number>((resolve) => answers.push(resolve));
    return { lease: { state: "HELD", holder: "anna", position: place } };
  });
  tell("declined", { component_ref: OPERATED, request_id: "r", reason: "its holder keeps it" });
  const asked = body.askAgain();
  await settle();
  for (const answer of answers.splice(1)) answer(1);
  await settle();
  answers[0]?.(0);
  await asked;
  await settle();
  expect(body.state).toEqual({ kind: "waiting", holder: "anna", position: 1, declined: false });
});

it("forgets a request when its time is over", async () => {
  await body.takeControl();
  tell("requested", { component_ref: OPERATED, request_id: "r1", subject: "ben", answer_ms: 1000 });
  await settle();
  await vi.advanceTimersByTimeAsync(1000);
  expect(body.nextRequest).toBeNull();
});

it("takes nothing of an avatar that is not chosen any more", async () => {
  const taken = body.takeControl();
  body.setComponents(["b/teleoperation", "b/navigation"]);
  await expect(taken).rejects.toThrow("Another body was chosen.");
  await settle();
  expect(verbs()).toEqual([`bind ${OPERATED}`, `release ${OPERATED}`]);
  expect(body.state).toEqual({ kind: "free" });
  const giveBack = await body.takeControl();
  expect(verbs().slice(2)).toEqual(["bind b/teleoperation"]);
  giveBack();
});

it("takes nothing where a part is another's by the time that the rest is bound", async () => {
  gateway.on("rois.command.bind", (params) => {
    if (refOf(params) === "a/reaction")
      tell("changed", { component_ref: OPERATED, state: "HELD", holder: "root", reason: "" });
    return {};
  });
  await expect(body.takeControl()).rejects.toThrow("root has control. Ask for it first.");
  await settle();
  expect(verbs().slice(2)).toEqual([...HEADS].reverse().map((ref) => `release ${ref}`));
});

it("takes each component by itself where the gateway knows no parts", async () => {
  gateway.on("openrois.lease.query", () => ({ lease: { state: "FREE" } }));
  body.setComponents(["c/teleoperation", "c/navigation"]);
  await settle();
  await body.takeControl();
  expect(verbs()).toEqual(["bind c/teleoperation", "bind c/navigation"]);
  expect(body.parts.map(({ name, state }) => [name, state])).toEqual([
    ["teleoperation", "mine"],
    ["navigation", "mine"],
  ]);
});

it("knows of each part who has it, from which and for how long", async () => {
  body.setComponents(BODY, ["a/speech_synthesizer"]);
  await settle();
  const lent = { lender: "night watch", return_ms: 20_000 };
  // Of one component of a part or of another: it holds for the part.
  tell("changed", { component_ref: "a/navigation", state: "HELD", holder: "ann", ...lent, reason: "" });
  tell("changed", { component_ref: OPERATED, state: "HELD", holder: "ann", ...lent, reason: "" });
  const voice = { component_ref: "a/speech_synthesizer", part: "voice" };
  tell("changed", { ...voice, state: "ABSENT", holder: "bob", reason: "" });
  await vi.advanceTimersByTimeAsync(3500);
  expect(
    body.parts.map(({ name, state, holder, lender, seconds }) => [name, state, holder, lender, seconds]),
  ).toEqual([
    ["legs", "other", "ann", "night watch", 17],
    ["gesture", "free", "", "", 0],
    ["voice", "other", "bob", "", 0],
  ]);
  // What control does not need hinders nothing.
  expect(body.hindrance).toBe("ann");
  tell("changed", { component_ref: OPERATED, state: "FREE", reason: "" });
  expect([body.hindrance, body.state.kind]).toEqual(["", "free"]);
});

describe("what a program holds", () => {
  const returning = { lender: "night watch", return_ms: 30_000 };
  const back = { state: "HELD", holder: "night watch", reason: "the time is over" };

  beforeEach(async () => {
    held.set("a/navigation", "night watch");
    body.ranked = true;
    gateway
      .on("openrois.lease.borrow", (params) => {
        held.clear();
        return { lease: { ...params, state: "MINE", part: partOf(refOf(params)), ...returning } };
      })
      .on("openrois.lease.give_back", () => ({}));
    body.setComponents(BODY);
    await settle();
  });

  it("is taken over with all else, used for as long as that lasts, and handed back", async () => {
    expect(body.state).toEqual({ kind: "other", holder: "night watch", absent: false, mayTakeOver: true });
    const giveBack = await body.takeOver();
    expect(gateway.called("openrois.lease.borrow")).toEqual([
      { component_ref: OPERATED, duration_ms: 30_000 },
    ]);
    expect(verbs()).toEqual([`borrow ${OPERATED}`, "bind a/reaction"]);
    expect(body.state).toEqual({ kind: "mine", lender: "night watch" });
    await vi.advanceTimersByTimeAsync(20_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(3);
    giveBack();
    await settle();
    expect(verbs().slice(4)).toEqual(["release a/reaction", `give_back ${OPERATED}`]);
    expect(lost).toEqual([]);
    await vi.advanceTimersByTimeAsync(20_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(3);
  });

  it("goes back at once when the body is stopped while it is being taken over", async () => {
    gateway.on("openrois.stop_all", () => ({ stopped: [] }));
    const refused = expect(body.takeOver()).rejects.toMatchObject({ status: "ABORT" });
    gateway.notify("openrois.lease.stopped", { engine_id: "a", by: "bob", reason: "programs wait" });
    await refused;
    await settle();
    expect(verbs().at(-1)).toBe(`give_back ${OPERATED}`);
    await vi.advanceTimersByTimeAsync(20_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(1);
  });

  it("goes back when the page is not used, and the page says so", async () => {
    await body.takeOver();
    used = false;
    await vi.advanceTimersByTimeAsync(30_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(1);
    tell("changed", { component_ref: OPERATED, ...back });
    await settle();
    expect(lost).toEqual(["night watch has control now."]);
    expect(verbs()).toContain("release a/reaction");
    used = true;
    await vi.advanceTimersByTimeAsync(30_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(1);
  });

  it("is handed back by a button", async () => {
    await body.takeOver();
    body.handBack();
    await settle();
    expect(lost).toEqual(["You have handed control back to night watch."]);
    expect(verbs().slice(2)).toEqual(["release a/reaction", `give_back ${OPERATED}`]);
  });

  it("is asked for where it does not rank lower, and all else is let go", async () => {
    held.clear();
    held.set("a/reaction", "anna");
    body.setComponents([...BODY].reverse());
    body.setComponents(BODY);
    await settle();
    gateway.on("openrois.lease.borrow", () => ({ return_code: "OUT_OF_RESOURCES" }));
    await expect(body.takeOver()).rejects.toThrow("anna has control. Ask for it first.");
    await settle();
    expect(verbs()).toEqual([`bind ${OPERATED}`, "borrow a/reaction", `release ${OPERATED}`]);
    expect(body.state).toEqual({ kind: "other", holder: "anna", absent: false, mayTakeOver: false });
    const granted = body.requestControl();
    granted.catch(() => undefined);
    await settle();
    expect(verbs().at(-1)).toBe("request a/reaction");
  });

  it("is taken over part by part, and handed back so", async () => {
    const [legs] = body.parts;
    if (!legs) throw new Error("there are no legs");
    expect([body.mayTakeOver(legs), body.isTakenOver(legs)]).toEqual([true, false]);
    await body.takePart(legs);
    await body.takePart(legs);
    expect(verbs()).toEqual([`borrow ${OPERATED}`]);
    expect(body.parts[0]).toMatchObject({ state: "mine", lender: "night watch", seconds: 30 });
    expect(body.isTakenOver(legs)).toBe(true);
    await body.handBackPart(legs);
    expect(verbs()).toEqual([`borrow ${OPERATED}`, `give_back ${OPERATED}`]);
    expect(body.isTakenOver(legs)).toBe(false);
    await vi.advanceTimersByTimeAsync(30_000);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(1);
  });

  it("is not taken again when the connection is lost: a loan ends with it", async () => {
    await body.takeOver();
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(30_000);
    expect(lost).toEqual(["Control was lost with the connection."]);
    expect(gateway.called("openrois.lease.borrow")).toHaveLength(1);
    expect(verbs().filter((verb) => verb === `bind ${OPERATED}`)).toEqual([]);
  });

  it("is a program's where that shows no token and visitors do", async () => {
    tell("changed", { component_ref: OPERATED, state: "HELD", holder: "local", reason: "" });
    await settle();
    expect(body.state).toMatchObject({ holder: "A program", mayTakeOver: true });
    body.ranked = false;
    expect(body.hindrance).toBe("Another visitor");
  });

  it("is not taken over without tokens: there are no ranks then", async () => {
    body.ranked = false;
    expect(body.state).toEqual({ kind: "other", holder: "night watch", absent: false, mayTakeOver: false });
    await expect(body.takeControl()).rejects.toBeInstanceOf(BodyTaken);
    expect(gateway.called("openrois.lease.borrow")).toEqual([]);
  });
});
