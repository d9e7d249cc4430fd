import { beforeEach, expect, it, vi } from "vitest";
import { speak } from "../../../app/model/speech_loan.ts";
import { CommandFailed, RoISError } from "../../../sdk/rois/errors.ts";
import { Stops } from "../../../sdk/rois/stops.ts";

const REF = "a/speech_synthesizer";
const BUSY = new RoISError("OUT_OF_RESOURCES", "rois.command.bind");

let done: string[];
/** What each attempt to speak ends with. */
let ends: (Error | null)[];
let refusal: Error | null;
/** What happens while the voice is being borrowed. */
let meanwhile: () => void;

const control = {
  borrow: async (ref: string, { forOneCommand = false } = {}): Promise<null> => {
    done.push(`borrow ${ref} ${forOneCommand ? "for one" : "for long"}`);
    await meanwhile();
    if (refusal) throw refusal;
    return null;
  },
  giveBack: async (ref: string): Promise<void> => void done.push(`give back ${ref}`),
  unlessStopped: <T>(...work: Parameters<typeof stops.unlessStopped<T>>): Promise<T> =>
    stops.unlessStopped(...work),
};
const speech = {
  componentRef: REF,
  perform: vi.fn(async (): Promise<void> => {
    done.push("perform");
    const end = ends.shift();
    if (end) throw end;
  }),
};
let stopping: AbortController;
const stops = new Stops(() => undefined);
const say = (ranked = true): Promise<void> =>
  speak(control, speech, { speech_text: "Hi" }, ranked, stopping.signal);

beforeEach(() => {
  stopping = new AbortController();
  done = [];
  ends = [];
  refusal = null;
  meanwhile = () => undefined;
});

it("takes nothing where the voice is to be had", async () => {
  await say();
  expect(done).toEqual(["perform"]);
});

it("takes the voice for one sentence from an application that has it", async () => {
  ends = [BUSY];
  await say();
  expect(done).toEqual(["perform", `borrow ${REF} for one`, "perform", `give back ${REF}`]);
});

it("gives the voice back when it is stopped", async () => {
  ends = [BUSY, new CommandFailed(REF, "c", "ABORT", "")];
  await expect(say()).rejects.toBeInstanceOf(CommandFailed);
  expect(done.at(-1)).toBe(`give back ${REF}`);
});

it.each([
  ["it", () => stopping.abort()],
  ["the body", () => stops.handleStopped("a")],
])("says nothing when %s is stopped while the voice is being taken", async (_, stop) => {
  ends = [BUSY];
  meanwhile = stop;
  await expect(say()).rejects.toMatchObject({ status: "ABORT" });
  expect(done).toEqual(["perform", `borrow ${REF} for one`, `give back ${REF}`]);
});

it("says nothing where the other application does not rank lower, or there are no ranks", async () => {
  ends = [BUSY, BUSY];
  refusal = new RoISError("OUT_OF_RESOURCES", "openrois.lease.borrow");
  await expect(say()).rejects.toBe(refusal);
  await expect(say(false)).rejects.toBe(BUSY);
  expect(done).toEqual(["perform", `borrow ${REF} for one`, "perform"]);
});

it("takes nothing when it fails for another reason", async () => {
  ends = [new RoISError("ERROR", "rois.command.execute")];
  await expect(say()).rejects.toMatchObject({ returnCode: "ERROR" });
  expect(done).toEqual(["perform"]);
});
