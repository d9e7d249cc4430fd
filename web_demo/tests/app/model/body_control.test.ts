import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { BodyControl, BodyTaken } from "../../../app/model/body_control.ts";
import type { JsonObject } from "../../../sdk/jsonrpc/peer.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

const OPERATED = "a/teleoperation";
const BODY = [OPERATED, "a/navigation", "a/reaction"];

let gateway: FakeGateway;
let client: Client;
let body: BodyControl;
let lost: string[];
/** Who else holds what. */
let held: Map<string, string>;
/** Where in line this application stands for them. */
let position: number;

const refOf = ({ component_ref: ref }: JsonObject): string => String(ref);
const verbs = (): string[] =>
  gateway.calls
    .filter(({ method }) => /bind$|release$|grant$|decline$|lease.request$/.test(method))
    .map(({ method, params }) => `${method.split(".").at(-1)} ${params["component_ref"] ?? "-"}`);
const tell = (name: string, params: JsonObject): void => gateway.notify(`openrois.lease.${name}`, params);
const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(50);

beforeEach(async () => {
  vi.useFakeTimers();
  held = new Map();
  lost = [];
  position = 0;
  gateway = new FakeGateway(["openrois.lease"])
    .on("openrois.lease.token", () => ({ token: "t", grace_ms: 10_000 }))
    .on("openrois.lease.query", (params) => {
      const holder = held.get(refOf(params));
      return { lease: holder === undefined ? { state: "FREE" } : { state: "HELD", holder, position } };
    })
    .on("openrois.lease.request", () => ({ lease: { state: "HELD", position: 1 }, request_id: "r" }))
    .on("openrois.lease.grant", () => ({}))
    .on("openrois.lease.decline", () => ({}))
    .on("rois.command.bind", (params) => (held.has(refOf(params)) ? { return_code: "OUT_OF_RESOURCES" } : {}))
    .on("rois.command.release", () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  body = new BodyControl(client, () => undefined);
  body.onLost = (why) => void lost.push(why);
  body.setComponents(BODY);
  await settle();
});

afterEach(() => {
  vi.useRealTimers();
});

it("takes all parts once for several works, and gives them back with the last one, the operated one last", async () => {
  const [first, second] = await Promise.all([body.takeControl(), body.takeControl()]);
  expect(body.state).toEqual({ kind: "mine" });
  expect(verbs()).toEqual(BODY.map((ref) => `bind ${ref}`));
  first();
  first();
  await settle();
  expect(verbs()).toHaveLength(3);
  second();
  await settle();
  expect(verbs().slice(3)).toEqual([...BODY].reverse().map((ref) => `release ${ref}`));
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
      .slice(0, 3),
  ).toEqual([...BODY].reverse().map((ref) => `release ${ref}`));
  expect(body.state).toEqual({ kind: "free" });
  expect([body.holderOf("a/reaction"), body.holderOf("a/navigation")]).toEqual(["anna", ""]);
});

it("names who has control, and without tokens says that there is one", async () => {
  tell("changed", { component_ref: OPERATED, state: "HELD", holder: "ben", reason: "it was free" });
  await settle();
  expect(body.state).toEqual({ kind: "other", holder: "ben", absent: false });
  expect(body.holderOf("a/navigation")).toBe("ben");
  tell("changed", { component_ref: OPERATED, state: "ABSENT", holder: "local", reason: "" });
  await settle();
  expect(body.holderOf(null)).toBe("Another visitor");
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
  expect(verbs().slice(4, 7)).toEqual(["release a/reaction", "release a/navigation", "grant -"]);
  expect(lost).toEqual(["You have handed over control to Another visitor."]);
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
  expect(body.state).toEqual({ kind: "mine" });
  expect(verbs()).toEqual([
    `bind ${OPERATED}`,
    `release ${OPERATED}`,
    `request ${OPERATED}`,
    ...BODY.map((ref) => `bind ${ref}`),
  ]);
  giveBack();
  await settle();
  expect(verbs().slice(-3)).toEqual([...BODY].reverse().map((ref) => `release ${ref}`));
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
  expect(verbs().slice(2)).toEqual(["bind b/teleoperation", "bind b/navigation"]);
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
  expect(verbs().slice(3)).toEqual([...BODY].reverse().map((ref) => `release ${ref}`));
});
