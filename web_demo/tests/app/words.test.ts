import { describe, expect, it } from "vitest";
import { findBodies, movingParts } from "../../app/model/bodies.ts";
import { formatBitrate, formatLatency, formatTime, secondsUntil } from "../../app/model/format.ts";
import { describeCompleted, describeFailure } from "../../app/model/outcome.ts";
import { plainReason } from "../../app/model/plain_words.ts";
import { bestColumns, reactionLook } from "../../app/model/reaction_looks.ts";
import { History } from "../../app/dom/sparkline.ts";
import {
  CommandFailed,
  ConnectionLost,
  InvalidMessage,
  RequestTimeout,
  RoISError,
  RpcError,
} from "../../sdk/index.ts";
import type { Profile } from "../../sdk/index.ts";

describe("reactionLook", () => {
  it.each([
    ["urn:x-rois:def:reaction:OMG::1", "1", "Nod"],
    ["urn:x-rois:def:reaction:OMG::9", "9", "Bow"],
    ["urn:x-rois:def:reaction:OMG::37", "37", "Reaction 37"],
    ["urn:x-rois:def:reaction:OpenRoIS::look_around", "look_around", "Look around"],
    ["urn:x-rois:def:reaction:Example::do-a-flip", "do-a-flip", "Do a flip"],
    ["urn:x-rois:def:reaction:Example::constructor", "constructor", "Constructor"],
    ["plain", "plain", "Plain"],
    ["odd::", "", "Odd::"],
  ])("%s", (reactionRef, code, name) => {
    expect(reactionLook(reactionRef)).toMatchObject({ code, name });
    expect(reactionLook(reactionRef).path).toMatch(/^M/);
  });
});

describe("bestColumns", () => {
  it.each([
    [12, 6],
    [10, 5],
    [14, 7],
    [1, 5],
    [0, 6],
  ])("for %i buttons are %i", (count, columns) => {
    expect(bestColumns(count, [6, 5, 7])).toBe(columns);
  });
});

describe("outcomes in words", () => {
  const WAITS = "robot was stopped by ann: programs wait until a person hands it back";
  it.each([
    [describeCompleted("OK", 1849), "done", "done after 1.8 s"],
    [describeCompleted("ABORT", 400), "stopped", "stopped after 0.4 s"],
    [
      describeCompleted("ABORT", 400, "the speech was stopped at the word 'so' (character 23)"),
      "stopped",
      "the speech was stopped at the word 'so'",
    ],
    [describeCompleted("TIMEOUT", 1), "failed", "it took too long"],
    [describeFailure(new RoISError("OUT_OF_RESOURCES", "m"), "busy"), "refused", "busy"],
    [
      describeFailure(new RoISError("OUT_OF_RESOURCES", "m", "", WAITS), "busy"),
      "refused",
      "robot was stopped by ann: programs wait until a person hands it back",
    ],
    [describeFailure(new RoISError("ERROR", "m"), "busy"), "failed", "the body refused it"],
    [describeFailure(new RoISError("ERROR", "m", "", "no"), "busy"), "failed", "the body refused it: no"],
    [describeCompleted("ERROR", 5, "no voice"), "failed", "the body could not do it: no voice"],
    [
      describeFailure(new CommandFailed("enrol of a/b", "command-1", "ERROR", "no face"), "busy"),
      "failed",
      "no face",
    ],
    [
      describeFailure(new CommandFailed("enrol of a/b", "command-1", "ERROR"), "busy"),
      "failed",
      "the body could not do it",
    ],
    [
      describeFailure(new InvalidMessage("rois.command.bind: result must be an object"), "busy"),
      "failed",
      "the gateway's answer cannot be read; run an OpenRoIS gateway of this version",
    ],
    [describeFailure(new Error("x"), "busy"), "failed", "x"],
    [describeFailure("y", "busy"), "failed", "y"],
  ])("%o", (outcome, state, text) => {
    expect(outcome).toEqual({ state, text });
  });

  it.each([
    new RequestTimeout("rois.command.bind: no answer within 10000 ms"),
    new RpcError({ code: -32601, message: "Method not found" }, "rois.command.bind"),
    new InvalidMessage("rois.command.bind: result must be an object"),
    new ConnectionLost("command-1: the connection ended before the command did"),
  ])("names no method, id or code: %o", (error) => {
    expect(describeFailure(error).text).not.toMatch(/rois\.|command-|\d/);
  });

  it("tells a lost connection from a refusal", () => {
    expect(describeFailure(new ConnectionLost("m"), "busy").text).toMatch(/connection/);
  });
});

describe("reasons in plain words", () => {
  it.each([
    ["everything was stopped by local", "everything was stopped"],
    ["everything was stopped by anna", "everything was stopped by anna"],
    [
      "avatar/teleoperation is now held by local: its holder has handed it over",
      "Another application has control now",
    ],
    ["avatar/teleoperation is now held by ben: an administrator has taken it", "ben has control now"],
    ["avatar/teleoperation is now held by ben: an administrator has taken it", "ben has control now"],
    ["avatar/teleoperation is controlled by local now: it was free", "Another application has control now"],
    [`command-${"0a1b".repeat(6)}: the connection ended`, "the connection ended"],
    ["avatar/Arm did not confirm that it has stopped.", "Arm did not confirm that it has stopped"],
    [
      "start of avatar/speech_synthesizer did not end in time",
      "start of speech synthesizer did not end in time",
    ],
    ["home/avatar/navigation has to be bound first", "navigation has to be bound first"],
    ["0.5 km/h and 1/2 of 3 m/s are too fast", "0.5 km/h and 1/2 of 3 m/s are too fast"],
    ["STREAMING_NOT_CONNECTED", ""],
    ["1.5,2.0 is outside of the floor", "1.5,2.0 is outside of the floor"],
    ["", ""],
  ])("%s", (reason, words) => {
    expect(plainReason(reason)).toBe(words);
  });
});

/** Returns the profile of a gateway with an engine for each of the ids that lead the references. */
function tree(components: Profile["component_profiles"]): Profile {
  const refs = Object.keys(components);
  const engines = [...new Set(refs.map((ref) => ref.split("/")[0] ?? ""))];
  const sub_profiles = engines.map((code) => ({
    identifier: { code },
    component_ids: refs.filter((ref) => ref.startsWith(`${code}/`)),
  }));
  return { profile: { identifier: { code: "gateway" }, sub_profiles }, component_profiles: components };
}

describe("movingParts", () => {
  it("begins with what stands for all, and is the voice where there is no body", () => {
    const types = {
      video: "VideoStreaming",
      face: "Reaction",
      step: "Move",
      mouth: "SpeechSynthesis",
      tail: "Follow",
      legs: "Navigation",
      hands: "Teleoperation",
      eyes: "Gaze",
    };
    const body = (...names: (keyof typeof types)[]): string[][] =>
      findBodies(
        tree(
          Object.fromEntries(names.map((name) => [`a/${name}`, { identifier: { code: types[name] }, name }])),
        ),
      ).map(movingParts);
    expect(body("video", "face", "step", "mouth", "tail", "legs", "hands", "eyes")).toEqual([
      ["a/hands", "a/legs", "a/step", "a/tail", "a/face", "a/eyes"],
    ]);
    expect(body("video", "mouth")).toEqual([["a/mouth"]]);
    expect(body("video")).toEqual([[]]);
  });
});

describe("numbers in words", () => {
  it("have the digits that matter", () => {
    expect([formatLatency(null), formatLatency(3.44), formatLatency(38.6)]).toEqual(["", "3.4", "39"]);
    expect(formatLatency(-27)).toBe("0.0");
    expect(formatBitrate(812_345)).toEqual(["812", "kbit/s"]);
    expect(formatBitrate(2_345_678)).toEqual(["2.35", "Mbit/s"]);
    expect(formatTime(new Date(2026, 7, 1, 3, 4, 5, 6).getTime())).toBe("03:04:05.006");
  });

  it("count down to 0 and no further", () => {
    expect([secondsUntil(5000, 1), secondsUntil(5000, 4999), secondsUntil(5000, 9000)]).toEqual([5, 1, 0]);
  });
});

describe("History", () => {
  it("draws from the right, with the area down to 0", () => {
    const history = new History(3);
    history.push(50);
    history.push(100);
    expect(history.paths(100, 10)).toEqual({
      line: "M50.0 6.0L100.0 2.0",
      area: "M50.0 10L50.0 6.0L100.0 2.0L100.0 10Z",
    });
  });

  it("leaves gaps, forgets the oldest, and survives nothing but zeros", () => {
    const history = new History(4);
    for (const value of [9, 8, null, 4, 4]) history.push(value);
    expect(history.paths(30, 10).line).toBe("M0.0 2.0M20.0 6.0L30.0 6.0");
    const flat = new History(2);
    flat.push(0);
    expect(flat.paths(10, 10).line).toBe("M10.0 10.0");
    expect(new History().paths(10, 10)).toEqual({ line: "", area: "" });
  });
});

describe("findBodies", () => {
  const component = (code: string) => ({ identifier: { code }, name: "x" });

  it("takes every engine that the page has a panel for, with the components it has", () => {
    const profile = tree({
      "a/eyes": component("urn:x-rois:def:component:OMG::VideoStreaming"),
      "a/mouth": component("urn:x-rois:def:component:OMG::SpeechSynthesis"),
      "b/speech": component("urn:x-rois:def:component:OMG::SpeechSynthesis"),
      "c/video": component("VideoStreaming"),
      "c/video2": component("VideoStreaming"),
      "d/lamp": component("urn:x-rois:def:component:Example::Lamp"),
    });
    const nothing = {
      video: null,
      operator: null,
      audio: null,
      speech: null,
      reaction: null,
      system: null,
      gaze: null,
      teleoperation: null,
      surroundings: null,
      viewpoint: null,
      navigation: null,
      move: null,
      follow: null,
      progress: null,
      dialogue: null,
      sight: null,
      enrolment: null,
      hearing: null,
      visitors: null,
    };
    expect(findBodies(profile)).toEqual([
      { ...nothing, engineId: "a", video: "a/eyes", speech: "a/mouth" },
      { ...nothing, engineId: "b", speech: "b/speech" },
      { ...nothing, engineId: "c", video: "c/video" },
    ]);
  });
});
