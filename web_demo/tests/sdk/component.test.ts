import { beforeEach, describe, expect, it, vi } from "vitest";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { Client } from "../../sdk/rois/client.ts";
import { CommandFailed, RoISError, ValueError } from "../../sdk/rois/errors.ts";
import {
  AudioStreaming,
  Navigation,
  PersonDetection,
  Reaction,
  SpeechSynthesis,
} from "../../sdk/rois/generated/components.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

let gateway: FakeGateway;
let client: Client;

const units = (): JsonObject[] =>
  gateway
    .called("rois.command.execute")
    .flatMap((params) => params["command_unit_list"] as { command_id: string }[]);

const complete = (index: number, status: string): void => {
  const { command_id = "" } = units().at(index) ?? {};
  gateway.notify("rois.command.completed", { command_id, status });
};

const steps = (): string[] =>
  gateway.calls
    .map((call) => call.method.replace("rois.command.", ""))
    .filter((method) => !method.includes("."));

/** Every command ends in the same breath in which it is accepted. */
const completeAtOnce = (status = "OK"): void => {
  gateway.on("rois.command.execute", (params) => {
    const list = params["command_unit_list"] as { command_id: string }[];
    for (const { command_id } of list) {
      queueMicrotask(() => gateway.notify("rois.command.completed", { command_id, status }));
    }
    return {};
  });
};

beforeEach(async () => {
  gateway = new FakeGateway();
  for (const method of ["bind", "release", "execute"]) gateway.on(`rois.command.${method}`, () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
});

describe("finding", () => {
  it("asks for the type, and for what else must hold", async () => {
    gateway.on("rois.command.search", () => ({ component_ref_list: ["robot/navigation"] }));
    const navigation = await client.find(Navigation, "component_ref LIKE 'r%'");
    expect(navigation).toBeInstanceOf(Navigation);
    expect(navigation.componentRef).toBe("robot/navigation");
    expect(gateway.called("rois.command.search")).toEqual([
      {
        condition: "component_type = 'urn:x-rois:def:component:OMG::Navigation' AND component_ref LIKE 'r%'",
      },
    ]);
  });

  it("says which there are where there are several", async () => {
    gateway.on("rois.command.search", () => ({
      component_ref_list: ["robot/navigation", "cart/navigation"],
    }));
    await expect(client.find(Navigation)).rejects.toMatchObject({
      returnCode: "BAD_PARAMETER",
      reason:
        "there are 2: robot/navigation, cart/navigation; take one that is free by `client.body`, or name one by a condition",
    });
    const all = await client.findAll(Navigation);
    expect(all.map(({ componentRef }) => componentRef)).toEqual(["robot/navigation", "cart/navigation"]);
  });

  it("reads the profiles where the gateway compares the code of the identifier alone", async () => {
    const of = (code: string, authority = "") => ({ identifier: { code, authority }, name: "x" });
    gateway.on("rois.command.search", () => ({ component_ref_list: [] }));
    gateway.on("rois.system.get_profile", () => ({
      component_profiles: {
        "a/legs": of("Navigation", "OMG"),
        "b/legs": of("urn:x-rois:def:component:OMG::Navigation"),
        "c/legs": of("Navigation", "Example"),
        "d/arm": of("Move", "OMG"),
      },
    }));
    const all = await client.findAll(Navigation, "component_ref LIKE '%'");
    expect(all.map(({ componentRef }) => componentRef)).toEqual(["a/legs", "b/legs"]);
    expect(gateway.called("rois.system.get_profile")).toEqual([{ condition: "component_ref LIKE '%'" }]);
  });

  it("throws where no component matches", async () => {
    gateway.on("rois.system.get_profile", () => ({ component_profiles: {} }));
    await expect(client.find(Navigation)).rejects.toMatchObject({
      returnCode: "UNSUPPORTED",
      reason: "there is no such component",
    });
    await expect(client.findAll(Navigation)).resolves.toEqual([]);
  });
});

describe("commands", () => {
  it("resolve when they end OK", async () => {
    const navigation = new Navigation(client, "robot/navigation");
    const ended = vi.fn();
    const start = navigation.start().then(ended);
    await vi.waitFor(() => expect(units()).toHaveLength(1));
    expect(units()[0]).toEqual({
      component_ref: "robot/navigation",
      command_type: "start",
      command_id: expect.any(String),
    });
    expect(ended).not.toHaveBeenCalled();
    complete(0, "OK");
    await start;
    expect(ended).toHaveBeenCalledOnce();
  });

  it("throw when they do not end OK", async () => {
    completeAtOnce("ABORT");
    const failed = new Navigation(client, "robot/navigation").suspend();
    await expect(failed).rejects.toBeInstanceOf(CommandFailed);
    await expect(failed).rejects.toMatchObject({
      status: "ABORT",
      message: "suspend of robot/navigation: ABORT",
    });
  });

  it("pass on the reason for their failure", async () => {
    gateway.on("rois.command.execute", ({ command_unit_list }) => {
      const [{ command_id }] = command_unit_list as unknown as [{ command_id: string }];
      queueMicrotask(() => {
        gateway.notify("openrois.reason", { command_id, reason: "set target_positions first" });
        gateway.notify("rois.command.completed", { command_id, status: "ERROR" });
      });
      return {};
    });
    const navigation = new Navigation(client, "robot/navigation");
    await expect(navigation.start()).rejects.toMatchObject({
      status: "ERROR",
      reason: "set target_positions first",
      message: "start of robot/navigation: ERROR (set target_positions first)",
    });
    gateway.on("rois.command.execute", ({ command_unit_list }) => {
      const [{ command_id }] = command_unit_list as unknown as [{ command_id: string }];
      gateway.notify("openrois.reason", { command_id: "another", reason: "of another" });
      queueMicrotask(() => gateway.notify("rois.command.completed", { command_id, status: "ABORT" }));
      return {};
    });
    await expect(navigation.start()).rejects.toMatchObject({
      reason: "",
      message: "start of robot/navigation: ABORT",
    });
  });

  it("carry arguments and give results", async () => {
    completeAtOnce();
    gateway.on("rois.command.get_command_result", () => ({
      results: [{ name: "stream_id", data_type_ref: "string", value: "s-1" }],
    }));
    const audio = new AudioStreaming(client, "robot/audio");
    await expect(audio.connectStream()).resolves.toEqual({ stream_id: "s-1" });
    const asked = gateway.called("rois.command.get_command_result");
    expect(asked).toEqual([{ command_id: units()[0]?.["command_id"] }]);
    await audio.suspendStream({ stream_id: "s-1" });
    expect(units()[1]).toMatchObject({
      command_type: "suspend_stream",
      arguments: [{ name: "stream_id", data_type_ref: "String", value: "s-1" }],
    });
  });

  it("say what is wrong with a result", async () => {
    completeAtOnce();
    gateway.on("rois.command.get_command_result", () => ({}));
    const connected = new AudioStreaming(client, "robot/audio").connectStream();
    await expect(connected).rejects.toThrow(new ValueError("stream_id is missing"));
  });
});

describe("parameters", () => {
  const parameters = [
    { name: "target_positions", data_type_ref: "string[]", value: '["lobby"]' },
    { name: "time_limit", data_type_ref: "int", value: "60000" },
  ];

  it("are read and written as what they are", async () => {
    gateway.on("rois.command.get_parameter", () => ({ parameters }));
    gateway.on("rois.command.set_parameter", () => {
      queueMicrotask(() =>
        gateway.notify("rois.command.completed", { command_id: "robot/p1", status: "OK" }),
      );
      return { command_id: "robot/p1" };
    });
    const navigation = new Navigation(client, "robot/navigation");
    await expect(navigation.getParameter()).resolves.toEqual({
      target_positions: ["lobby"],
      time_limit: 60_000,
    });
    await navigation.setParameter({ target_positions: ["lobby"], time_limit: 60_000 });
    expect(gateway.called("rois.command.set_parameter")).toEqual([
      { component_ref: "robot/navigation", parameters },
    ]);
  });

  it("are refused before they are sent when they do not fit", async () => {
    const navigation = new Navigation(client, "robot/navigation");
    await expect(navigation.setParameter({ time_limit: 0.5 })).rejects.toThrow(
      new ValueError('time_limit: "0.5" is not of type int'),
    );
    // @ts-expect-error: TypeScript knows that there is no such parameter
    await expect(navigation.setParameter({ colour: "red" })).rejects.toThrow(
      /there is no value called colour: use one of target_positions, /,
    );
    expect(gateway.called("rois.command.set_parameter")).toEqual([]);
  });
});

describe("queries", () => {
  it("ask this component and no other", async () => {
    gateway.on("rois.query.query", () => ({
      results: [{ name: "status", data_type_ref: "Component_Status", value: "BUSY" }],
    }));
    await expect(new Navigation(client, "robot/navigation").componentStatus()).resolves.toEqual({
      status: "BUSY",
    });
    gateway.on("rois.query.query", () => ({
      results: [{ name: "status", data_type_ref: "Stream_Status", value: "STREAMING_RUNNING" }],
    }));
    await new AudioStreaming(client, "robot/audio").getStreamStatus("stream_id = 's-1'");
    expect(gateway.called("rois.query.query")).toEqual([
      { query_type: "component_status", condition: "component_ref = 'robot/navigation'" },
      { query_type: "get_stream_status", condition: "component_ref = 'robot/audio' AND stream_id = 's-1'" },
    ]);
  });
});

describe("events", () => {
  const NOON = "2026-06-01T12:00:00+00:00";
  const detected = (number: string): JsonObject[] => [
    { name: "number", data_type_ref: "int", value: number },
    { name: "timestamp", data_type_ref: "DateTime", value: NOON },
  ];
  const happen = (results: JsonObject[] | null, event_id = "robot/e1"): void =>
    gateway.notify("rois.event.notify_event", {
      event_id,
      event_type: "person_detected",
      subscribe_id: "robot/s1",
      ...(results && { results }),
    });
  let persons: PersonDetection;

  beforeEach(() => {
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "robot/s1" }));
    gateway.on("rois.event.unsubscribe", () => ({}));
    persons = new PersonDetection(client, "robot/persons");
  });

  it("arrive with typed payloads", async () => {
    const heard = vi.fn();
    const subscription = await persons.personDetected.subscribe(heard);
    expect(gateway.called("rois.event.subscribe")).toEqual([
      { event_type: "person_detected", condition: "component_ref = 'robot/persons'" },
    ]);
    happen(detected("2"));
    await vi.waitFor(() => expect(heard).toHaveBeenCalledOnce());
    expect(heard.mock.calls[0]?.[0]).toEqual({ number: 2, timestamp: new Date(NOON) });
    expect(heard.mock.calls[0]?.[1]).toMatchObject({ event_id: "robot/e1", expire: "" });
    await subscription.cancel();
    expect(gateway.called("rois.event.unsubscribe")).toEqual([{ subscribe_id: "robot/s1" }]);
  });

  it("are asked for where an engine sends no results, and stay in order", async () => {
    gateway.on("rois.event.get_event_detail", () => ({ results: detected("1") }));
    const heard: number[] = [];
    await persons.personDetected.subscribe(({ number }) => heard.push(number));
    happen(null);
    happen(detected("2"), "robot/e2");
    await vi.waitFor(() => expect(heard).toEqual([1, 2]));
    expect(gateway.called("rois.event.get_event_detail")).toEqual([{ event_id: "robot/e1" }]);
  });

  it("do not wait for an async listener", async () => {
    const heard: number[] = [];
    await persons.personDetected.subscribe(({ number }) => {
      heard.push(number);
      return new Promise(() => undefined) as unknown as undefined;
    });
    happen(detected("1"));
    happen(detected("2"));
    await vi.waitFor(() => expect(heard).toEqual([1, 2]));
  });

  it("that cannot be read are reported and ignored", async () => {
    const invalid = vi.fn();
    client.on("invalid", invalid);
    const heard = vi.fn();
    await persons.personDetected.subscribe(heard);
    happen(detected("many"));
    happen([{ name: "number", data_type_ref: "int", value: "1" }]);
    happen([detected("1")[0] ?? {}, { name: "timestamp", data_type_ref: "DateTime", value: "noon" }]);
    happen(detected("3"));
    await vi.waitFor(() => expect(heard).toHaveBeenCalledOnce());
    expect(invalid.mock.calls.map(([what]) => what)).toEqual([
      'person_detected of robot/persons: ValueError: number: "many" is not of type int',
      "person_detected of robot/persons: ValueError: timestamp is missing",
      'person_detected of robot/persons: ValueError: timestamp: "noon" is not of type DateTime',
    ]);
  });

  it("reach every listener, even past one that throws", async () => {
    const failing = vi.spyOn(console, "error").mockImplementation(() => undefined);
    let heard = 0;
    await persons.personDetected.subscribe(() => {
      heard += 1;
      throw new Error("mine");
    });
    happen(detected("1"));
    happen(detected("2"));
    await vi.waitFor(() => expect(heard).toBe(2));
    expect(failing).toHaveBeenCalledTimes(2);
    failing.mockRestore();
  });

  it("are iterated over until the loop ends", async () => {
    const numbers: number[] = [];
    const reading = (async () => {
      for await (const { number } of persons.personDetected) {
        numbers.push(number);
        if (number === 3) break;
      }
    })();
    await vi.waitFor(() => expect(gateway.called("rois.event.subscribe")).toHaveLength(1));
    // All in one breath with the answer to subscribe: nothing is missed.
    for (const number of ["1", "2", "3", "4"]) happen(detected(number));
    await reading;
    expect(numbers).toEqual([1, 2, 3]);
    expect(gateway.called("rois.event.unsubscribe")).toEqual([{ subscribe_id: "robot/s1" }]);
  });

  it("end for their reader with the client", async () => {
    gateway.on("rois.system.disconnect", () => ({}));
    const reading = (async () => {
      const numbers: number[] = [];
      for await (const { number } of persons.personDetected) numbers.push(number);
      return numbers;
    })();
    await vi.waitFor(() => expect(gateway.called("rois.event.subscribe")).toHaveLength(1));
    happen(detected("1"));
    await client.close();
    await expect(reading).resolves.toEqual([1]);
  });

  it("are dropped for a slow reader, the oldest first", async () => {
    const iterator = persons.personDetected[Symbol.asyncIterator]();
    const first = iterator.next();
    await vi.waitFor(() => expect(gateway.called("rois.event.subscribe")).toHaveLength(1));
    happen(detected("0"));
    await expect(first).resolves.toMatchObject({ value: { number: 0 } });
    for (let number = 1; number <= 300; number++) happen(detected(String(number)));
    await expect(iterator.next()).resolves.toMatchObject({ value: { number: 45 } });
    await iterator.return();
  });

  it("throw where the engine refuses the subscription", async () => {
    gateway.on("rois.event.subscribe", () => ({ return_code: "UNSUPPORTED" }));
    await expect(persons.personDetected[Symbol.asyncIterator]().next()).rejects.toBeInstanceOf(RoISError);
  });
});

describe("perform", () => {
  it("binds, sets and starts in one sequence, waits for both, releases", async () => {
    const speech = new SpeechSynthesis(client, "a/speech");
    const started = vi.fn();
    const performance = speech.perform({ speech_text: "Hello", volume: 70 }, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalled());
    expect(speech.inUse).toBe(true);
    expect(steps()).toEqual(["bind", "execute"]);
    expect(units()).toMatchObject([
      {
        component_ref: "a/speech",
        command_type: "set_parameter",
        arguments: [
          { name: "speech_text", data_type_ref: "string", value: "Hello" },
          { name: "volume", data_type_ref: "int", value: "70" },
        ],
      },
      { component_ref: "a/speech", command_type: "start" },
    ]);
    complete(0, "OK");
    complete(1, "OK");
    await performance;
    expect(steps()).toEqual(["bind", "execute", "release"]);
    expect(speech.inUse).toBe(false);
  });

  it("reports the first command that did not end OK", async () => {
    const started = vi.fn();
    const performance = new Reaction(client, "a/reaction").perform({ reaction_ref: "nod" }, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalled());
    complete(0, "ERROR");
    complete(1, "ABORT");
    await expect(performance).rejects.toMatchObject({ status: "ERROR" });
  });

  it("keeps the component while performances overlap", async () => {
    const speech = new SpeechSynthesis(client, "a/speech");
    const started = vi.fn();
    const first = speech.perform({}, started);
    const second = speech.perform({}, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalledTimes(2));
    complete(0, "OK");
    complete(1, "ABORT");
    await expect(first).rejects.toMatchObject({ status: "ABORT" });
    expect(steps()).not.toContain("release");
    complete(2, "OK");
    complete(3, "OK");
    await second;
    expect(steps().at(-1)).toBe("release");
  });

  it("is not begun when it is stopped before it could be", async () => {
    const speech = new SpeechSynthesis(client, "a/speech");
    const performance = speech.perform({ speech_text: "Hello" });
    const stopping = speech.stop();
    await expect(performance).rejects.toMatchObject({
      status: "ABORT",
      reason: "it was stopped before it began",
    });
    await vi.waitFor(() => expect(units()).toMatchObject([{ command_type: "stop" }]));
    complete(0, "OK");
    await stopping;
    expect(speech.inUse).toBe(false);
    completeAtOnce();
    await speech.perform({ speech_text: "Again" });
  });

  it.each([["a"], [undefined]])(
    "is not begun when everything is stopped before it could be (%s)",
    async (engine) => {
      gateway.on("openrois.stop_all", () => ({ stopped: ["a/speech"], failed: [] }));
      const speech = new SpeechSynthesis(client, "a/speech");
      const performance = speech.perform({ speech_text: "Hello" });
      await client.control.stopAll(engine);
      await expect(performance).rejects.toMatchObject({
        status: "ABORT",
        reason: "it was stopped before it began",
      });
      expect(units()).toEqual([]);
      expect(steps()).toEqual(["bind", "release"]);
      completeAtOnce();
      await speech.perform({ speech_text: "Again" });
    },
  );

  it("is not begun when a person stops the body before it could be", async () => {
    const speech = new SpeechSynthesis(client, "a/speech");
    const told = { engine_id: "a", by: "ann", reason: "programs wait" };
    const performance = speech.perform({ speech_text: "Hello" });
    gateway.notify("openrois.lease.stopped", told);
    await expect(performance).rejects.toMatchObject({ status: "ABORT" });
    expect(units()).toEqual([]);
    completeAtOnce();
    gateway.on("openrois.stop_all", async () => {
      // What is asked for behind a STOP of its own is no part of what the gateway tells of that.
      const again = speech.perform({ speech_text: "Again" });
      gateway.notify("openrois.lease.stopped", told);
      await again;
      return { stopped: [] };
    });
    await client.control.stopAll("a");
    const further = speech.perform({ speech_text: "Further" });
    gateway.notify("openrois.lease.stopped", { engine_id: "a", by: "", reason: "handed back" });
    gateway.notify("openrois.lease.stopped", { ...told, engine_id: "b" });
    await further;
  });

  it("goes on when another body is stopped", async () => {
    gateway.on("openrois.stop_all", () => ({ stopped: [], failed: [] }));
    completeAtOnce();
    const performance = new SpeechSynthesis(client, "a/speech").perform({ speech_text: "Hello" });
    await client.control.stopAll("ab");
    await performance;
  });

  it("throws when another application holds the component, and can be used again", async () => {
    gateway.on("rois.command.bind", () => ({ return_code: "OUT_OF_RESOURCES" }));
    const speech = new SpeechSynthesis(client, "a/speech");
    await expect(speech.perform({})).rejects.toBeInstanceOf(RoISError);
    expect(speech.inUse).toBe(false);
    gateway.on("rois.command.bind", () => ({}));
    completeAtOnce();
    await speech.perform({});
  });

  it("refuses what does not fit before anything is done", async () => {
    await expect(new SpeechSynthesis(client, "a/speech").perform({ volume: 0.5 })).rejects.toThrow(
      ValueError,
    );
    expect(steps()).toEqual([]);
  });

  it("keeps the component while another part of the program uses it, or has bound it", async () => {
    const [one, other] = [new Navigation(client, "r/n"), new Navigation(client, "r/n")];
    let finish = (): void => undefined;
    const long = one.bound(() => new Promise<void>((resolve) => (finish = resolve)));
    await other.bound(async () => undefined);
    expect(steps()).not.toContain("release");
    finish();
    await long;
    expect(steps().at(-1)).toBe("release");
    await one.bind();
    await other.bound(async () => undefined);
    expect(steps().at(-1)).toBe("bind");
    await one.release();
    expect(steps().at(-1)).toBe("release");
  });

  it("gives back what the work of `bound` gives", async () => {
    const navigation = new Navigation(client, "robot/navigation");
    await expect(navigation.bound(() => Promise.resolve(7))).resolves.toBe(7);
    expect(steps()).toEqual(["bind", "release"]);
  });
});
