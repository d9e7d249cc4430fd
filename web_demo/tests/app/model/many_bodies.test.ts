/** A thousand bodies: the page reads entries alone, lists a page of them, and asks about what it lists. */

import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { BodyDirectory } from "../../../app/model/bodies.ts";
import { BodyHolders } from "../../../app/model/body_holders.ts";
import { BodyList, PAGE } from "../../../app/model/body_list.ts";
import { Client } from "../../../sdk/index.ts";
import { FakeDirectory } from "../../support/fake_directory.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

const COUNT = 1000;
const idOf = (number: number): string => `robot-${String(number).padStart(4, "0")}`;

let gateway: FakeGateway;
let engines: FakeDirectory;
let client: Client;
let directory: BodyDirectory;
let changes: number;

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(0);

beforeEach(async () => {
  vi.useFakeTimers();
  gateway = new FakeGateway(["openrois.directory", "openrois.lease"])
    .on("openrois.lease.token", () => ({ token: "t", grace_ms: 10_000 }))
    .on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }))
    .on("openrois.lease.query", ({ component_ref: ref }) => ({
      lease: { component_ref: ref ?? "", state: "FREE", holder: "", epoch: 1, waiting: 0, position: 0 },
    }));
  engines = new FakeDirectory(gateway);
  for (let number = 0; number < COUNT; number++) engines.put(idOf(number), ["Navigation", "SpeechSynthesis"]);
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: { random: () => 1 } });
  changes = 0;
  directory = new BodyDirectory(client, () => (changes += 1));
  await client.connect();
  await settle();
});

afterEach(async () => {
  await client.close();
  vi.useRealTimers();
});

describe("the directory of the page", () => {
  it("reads entries in pages, and no profile", () => {
    expect(directory.bodies).toHaveLength(COUNT);
    expect(directory.chosen).toMatchObject({ engineId: idOf(0), navigation: `${idOf(0)}/navigation` });
    expect(gateway.called("openrois.directory.list")).toHaveLength(11);
    expect(gateway.called("rois.system.get_profile")).toEqual([]);
    expect(gateway.called("openrois.directory.profiles")).toEqual([]);
  });

  it("reads what has changed, and keeps the others as they were", async () => {
    const before = directory.bodies;
    gateway.calls.length = 0;
    engines.put(idOf(7), ["Navigation"]).remove(idOf(8));
    engines.notify([idOf(7), idOf(9)], [idOf(8)]);
    await settle();
    expect(gateway.calls.map(({ method }) => method)).toEqual(["openrois.directory.read"]);
    const now = new Map(directory.bodies?.map((body) => [body.engineId, body]));
    expect(now.size).toBe(COUNT - 1);
    expect(now.get(idOf(7))).toMatchObject({ speech: null });
    const same = before?.filter((body) => now.get(body.engineId) === body);
    // One that came back looks as before, and is another one all the same.
    expect(same).toHaveLength(COUNT - 3);
  });

  it("keeps none as it was where any may have changed, or after a reconnect", async () => {
    const before = directory.bodies ?? [];
    engines.notify([], [], 1);
    await settle();
    const between = directory.bodies ?? [];
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(1000);
    const after = directory.bodies ?? [];
    expect(after).toEqual(before);
    for (const each of [before, after]) expect(between.filter((body) => each.includes(body))).toEqual([]);
  });

  it("reads once more, not once each, when changes come faster than replies", async () => {
    gateway.calls.length = 0;
    for (let number = 0; number < 5; number++) engines.notify([idOf(number)]);
    await settle();
    expect(gateway.called("openrois.directory.read").length).toBeLessThanOrEqual(2);
  });
});

describe("the list", () => {
  let list: BodyList;
  const listed = (): string[] => list.listed.map(({ engineId }) => engineId);

  beforeEach(() => {
    list = new BodyList();
    list.setBodies(directory.bodies ?? [], idOf(0));
  });

  it("has a page, and one more each time", () => {
    expect([list.isLong, list.count, list.found, list.more]).toEqual([true, COUNT - 1, COUNT - 1, PAGE]);
    expect(listed()).toEqual(Array.from({ length: PAGE }, (_, place) => idOf(place + 1)));
    list.showMore();
    expect(listed()).toHaveLength(2 * PAGE);
    for (let page = 2; page < 19; page++) list.showMore();
    expect(list.more).toBe(PAGE - 1);
    list.showMore();
    expect([list.more, listed().length]).toEqual([0, COUNT - 1]);
  });

  it("finds bodies by words in their ids, wherever they stand", () => {
    list.showMore();
    list.search = "ROBOT 77";
    expect(listed()).toHaveLength(20 - 1);
    expect([list.found, list.more]).toEqual([19, 0]);
    list.search = "0999";
    expect(listed()).toEqual([idOf(999)]);
    list.search = "0000";
    expect(listed()).toEqual([]);
    list.search = " ";
    expect(listed()).toHaveLength(PAGE);
  });

  it("searches on while bodies come and go, until there are few", () => {
    list.search = "-099";
    list.setBodies(directory.bodies?.filter(({ engineId }) => engineId !== idOf(990)) ?? [], idOf(0));
    expect(listed()).toEqual(Array.from({ length: 9 }, (_, place) => idOf(991 + place)));
    list.setBodies(directory.bodies?.slice(0, PAGE + 1) ?? [], idOf(0));
    expect([list.isLong, list.search, list.more, listed().length]).toEqual([false, "", 0, PAGE]);
  });
});

describe("who has control", () => {
  let holders: BodyHolders;
  let told: number;
  const asked = (): unknown[] => gateway.called("openrois.lease.query").map(({ component_ref: ref }) => ref);
  const lease = (ref: string, state: string, holder = ""): void =>
    gateway.notify("openrois.lease.changed", { component_ref: ref, state, holder, reason: "" });

  beforeEach(() => {
    told = 0;
    holders = new BodyHolders(client, () => (told += 1));
  });

  it("is asked of those that are listed alone, a few at a time, and once", async () => {
    const bodies = directory.bodies?.slice(0, PAGE) ?? [];
    const answers: (() => void)[] = [];
    gateway.on("openrois.lease.query", () => new Promise((resolve) => answers.push(() => resolve({}))));
    holders.watch(bodies);
    await settle();
    expect(asked()).toHaveLength(8);
    gateway.on("openrois.lease.query", () => ({ lease: { component_ref: "", state: "FREE" } }));
    for (const answer of answers) answer();
    await settle();
    expect(asked()).toEqual(bodies.map(({ navigation }) => navigation));
    holders.watch(bodies);
    holders.watch([...bodies.slice(1), ...(directory.bodies?.slice(PAGE, PAGE + 1) ?? [])]);
    await settle();
    expect(asked().slice(PAGE)).toEqual([`${idOf(PAGE)}/navigation`]);
  });

  it("is known once it was asked, and then as it changes", async () => {
    const [body, other] = directory.bodies ?? [];
    if (!body || !other) throw new Error("there are no bodies");
    expect(holders.of(body)).toBeNull();
    holders.watch([body]);
    await settle();
    expect([holders.of(body), holders.of(other), told]).toEqual([{ kind: "free" }, null, 1]);
    lease(`${idOf(0)}/navigation`, "HELD", "anna");
    expect(holders.of(body)).toEqual({ kind: "held", holder: "anna" });
    lease(`${idOf(0)}/navigation`, "ABSENT", "local");
    expect(holders.of(body)).toEqual({ kind: "held", holder: "Another visitor" });
    holders.ranked = true;
    expect(holders.of(body)).toEqual({ kind: "held", holder: "A program" });
    lease(`${idOf(0)}/navigation`, "MINE");
    expect(holders.of(body)).toEqual({ kind: "mine" });
    lease(`${idOf(1)}/navigation`, "HELD", "anna");
    expect(told).toBe(4);
    holders.watch([]);
    expect(holders.of(body)).toBeNull();
  });

  it("is not known where the gateway refuses, and not asked where it has no leases", async () => {
    const [body] = directory.bodies ?? [];
    if (!body) throw new Error("there are no bodies");
    gateway.on("openrois.lease.query", () => ({ return_code: "UNSUPPORTED" }));
    holders.watch([body]);
    await settle();
    expect([holders.of(body), told]).toEqual([null, 0]);
    const plain = new FakeGateway(null);
    const another = new Client("ws://test/", { webSocket: plain.webSocket });
    await another.connect();
    new BodyHolders(another, () => undefined).watch([body]);
    await settle();
    expect(plain.called("openrois.lease.query")).toEqual([]);
  });
});
