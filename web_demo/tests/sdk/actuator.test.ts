import { beforeEach, describe, expect, it, vi } from "vitest";
import { Actuator } from "../../sdk/rois/actuator.ts";
import { RoISClient } from "../../sdk/rois/client.ts";
import { RoISError } from "../../sdk/rois/types.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

let gateway: FakeGateway;
let actuator: Actuator;

const complete = (index: number, status: string): void => {
  const units = gateway
    .called("rois.command.execute")
    .flatMap((params) => params["command_unit_list"] as { command_id: string }[]);
  gateway.notify("rois.command.completed", { command_id: units.at(index)?.command_id ?? "", status });
};

const steps = (): string[] =>
  gateway.calls
    .map((call) => call.method.replace("rois.command.", ""))
    .filter((method) => !method.includes("."));

beforeEach(async () => {
  gateway = new FakeGateway();
  for (const method of ["bind", "release", "execute"]) gateway.on(`rois.command.${method}`, () => ({}));
  const client = new RoISClient({ url: "ws://test/", createSocket: gateway.createSocket });
  await client.connect();
  actuator = new Actuator(client, "a/speech");
});

describe("Actuator", () => {
  it("binds, executes, waits for both commands, releases", async () => {
    const started = vi.fn();
    const performance = actuator.perform({ speech_text: "Hello", language: "en" }, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalled());
    expect(actuator.active).toBe(true);
    expect(steps()).toEqual(["bind", "execute"]);
    expect(gateway.called("rois.command.execute")[0]).toMatchObject({
      command_unit_list: [
        {
          component_ref: "a/speech",
          command_type: "set_parameter",
          arguments: [
            { name: "speech_text", data_type_ref: "string", value: "Hello" },
            { name: "language", data_type_ref: "string", value: "en" },
          ],
        },
        { component_ref: "a/speech", command_type: "start" },
      ],
    });
    complete(0, "OK");
    complete(1, "OK");
    await expect(performance).resolves.toBe("OK");
    expect(steps()).toEqual(["bind", "execute", "release"]);
    expect(actuator.active).toBe(false);
  });

  it("reports the first command that did not end well", async () => {
    const started = vi.fn();
    const performance = actuator.perform({}, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalled());
    complete(0, "ERROR");
    complete(1, "ABORT");
    await expect(performance).resolves.toBe("ERROR");
  });

  it("keeps the component while performances overlap", async () => {
    const started = vi.fn();
    const first = actuator.perform({}, started);
    const second = actuator.perform({}, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalledTimes(2));
    complete(0, "OK");
    complete(1, "ABORT");
    await expect(first).resolves.toBe("ABORT");
    expect(steps()).not.toContain("release");
    complete(2, "OK");
    complete(3, "OK");
    await expect(second).resolves.toBe("OK");
    expect(steps().at(-1)).toBe("release");
  });

  it("throws when somebody else holds the component, and can be used again", async () => {
    gateway.on("rois.command.bind", () => ({ return_code: "OUT_OF_RESOURCES" }));
    await expect(actuator.perform({})).rejects.toBeInstanceOf(RoISError);
    expect(actuator.active).toBe(false);
    gateway.on("rois.command.bind", () => ({}));
    const started = vi.fn();
    void actuator.perform({}, started);
    await vi.waitFor(() => expect(started).toHaveBeenCalled());
  });

  it("stops with a command of its own", async () => {
    const stopping = actuator.stop();
    await vi.waitFor(() => expect(gateway.called("rois.command.execute")).toHaveLength(1));
    complete(0, "OK");
    await stopping;
    expect(gateway.called("rois.command.execute")[0]).toMatchObject({
      command_unit_list: [{ component_ref: "a/speech", command_type: "stop" }],
    });
  });
});
