import { beforeEach, describe, expect, it, vi } from "vitest";
import { Capture } from "../../sdk/media/capture.ts";
import { FakeDevices } from "../support/fake_devices.ts";

let fake: FakeDevices;
let microphone: Capture;

beforeEach(() => {
  fake = new FakeDevices();
  microphone = new Capture("audio", {}, fake.devices);
});

describe("a device", () => {
  it("is requested once when opened, and released when closed", async () => {
    expect(fake.asked).toEqual([]);
    expect(await microphone.open()).toBe(true);
    expect(await microphone.open()).toBe(true);
    expect(fake.asked).toHaveLength(1);
    expect(fake.asked[0]?.audio).toMatchObject({ echoCancellation: true });
    expect(fake.last.contentHint).toBe("speech");
    expect(microphone.deviceId).toBe("default");
    microphone.close();
    expect(fake.last.stopped).toBe(true);
    expect(microphone.track).toBeNull();
  });

  it("is released at once when consent comes too late", async () => {
    const opening = microphone.open();
    microphone.close();
    expect(await opening).toBe(false);
    expect(fake.last.stopped).toBe(true);
    expect(microphone.problem).toBeNull();
  });

  it("is changed for another, and stays when that one does not start", async () => {
    await microphone.open();
    const first = fake.last;
    expect(await microphone.open("d1")).toBe(true);
    expect(first.stopped).toBe(true);
    expect(fake.asked[1]?.audio).toMatchObject({ deviceId: { exact: "d1" } });
    fake.error = "NotReadableError";
    expect(await microphone.open("d0")).toBe(true);
    expect(microphone).toMatchObject({ deviceId: "d1", problem: { kind: "in-use" } });
    expect(fake.last.stopped).toBe(false);
  });

  it("is not asked for twice while the user hesitates: the last wish counts", async () => {
    const both = [microphone.open("d0"), microphone.open("d1")];
    await Promise.all(both);
    expect(microphone.deviceId).toBe("d1");
    expect(fake.tracks.map(({ stopped }) => stopped)).toEqual([true, false]);
  });

  it("that is unplugged is reported, and can be opened again", async () => {
    await microphone.open();
    const changed = vi.fn();
    microphone.onChange(changed);
    fake.last.onended?.();
    expect(microphone).toMatchObject({ track: null, problem: { kind: "lost" } });
    expect(changed).toHaveBeenCalledOnce();
    expect(await microphone.open()).toBe(true);
    expect(microphone.problem).toBeNull();
  });

  it("is one of those of its kind", async () => {
    expect((await microphone.list()).map(({ deviceId }) => deviceId)).toEqual(["d0", "d1"]);
  });
});

describe("what is wrong", () => {
  it.each([
    ["NotAllowedError", "refused", "Allow it"],
    ["SecurityError", "refused", "privacy settings"],
    ["NotFoundError", "no-device", "Plug one in"],
    ["OverconstrainedError", "no-device", "choose another"],
    ["NotReadableError", "in-use", "another program"],
    ["AbortError", "in-use", "another program"],
  ])("%s is %s, with what to do", async (name, kind, words) => {
    fake.error = name;
    expect(await microphone.open()).toBe(false);
    expect(microphone.problem?.kind).toBe(kind);
    expect(microphone.problem?.detail).toContain(words);
    expect(microphone.problem?.detail).toContain("microphone");
  });

  it.each([
    [false, "insecure", "https://"],
    [true, "no-device", "camera"],
  ])("a page without devices, secure: %s", async (secure, kind, words) => {
    vi.stubGlobal("isSecureContext", secure);
    const camera = new Capture("video", {}, undefined);
    expect(await camera.open()).toBe(false);
    expect(camera.problem).toMatchObject({ kind, detail: expect.stringContaining(words) as string });
    expect(await camera.list()).toEqual([]);
    vi.unstubAllGlobals();
  });
});
