/** The page: connects the SDK with panels and models. */

import { Client } from "../sdk/index.ts";
import { MediaReceiver, SAME_CLOCK, decodableCodecs, isLoopback, measureOffset } from "../sdk/media/index.ts";
import type { Desire, LocalStream, RemoteStream } from "../sdk/media/index.ts";
import { Activity } from "./dom/activity.ts";
import { byRole } from "./dom/elements.ts";
import { BodyDirectory, movingParts } from "./model/bodies.ts";
import type { PageBody } from "./model/bodies.ts";
import { Banner } from "./panels/banner.ts";
import { BodyControl } from "./model/body_control.ts";
import { Captions } from "./panels/captions.ts";
import { Control } from "./panels/control.ts";
import { DialogueCard } from "./panels/dialogue.ts";
import { FiguresPanel } from "./panels/figures.ts";
import { installFullscreen, toggleFullscreen } from "./panels/fullscreen.ts";
import { Handover } from "./panels/handover.ts";
import { Gaze } from "./panels/gaze.ts";
import { Header } from "./panels/header.ts";
import { MessageLog } from "./panels/log.ts";
import { MapCard } from "./map/map_card.ts";
import { recall, remember } from "./model/memory.ts";
import { OperatorCard } from "./panels/operator.ts";
import { OtherBodies } from "./panels/other_bodies.ts";
import { Overlay } from "./panels/overlay.ts";
import { PartsPanel } from "./panels/parts.ts";
import { AWAY, WATCHING } from "./model/permission.ts";
import { amid } from "./model/plain_words.ts";
import { Reactions } from "./panels/reactions.ts";
import { Readings } from "./model/readings.ts";
import { SayLine } from "./panels/say.ts";
import { installShortcuts } from "./panels/shortcuts.ts";
import { Sound } from "./panels/sound.ts";
import { Stage } from "./panels/stage.ts";
import { StopButton } from "./panels/stop_button.ts";
import { StoppedNote } from "./panels/stopped_note.ts";
import { StreamCard } from "./panels/stream_card.ts";
import { StoppedBodies } from "./model/stopped_bodies.ts";
import type { ActingBody } from "./model/stopped_bodies.ts";
import { PageToken, asksForTokens, isTurnedAway } from "./model/token.ts";
import { findTrouble } from "./model/trouble.ts";
import type { Unwelcome } from "./model/trouble.ts";
import { Views } from "./panels/views.ts";

declare global {
  interface Window {
    /** For the browser's console and for tests: the client and the streams of the page. */
    openrois: {
      client: Client;
      video: RemoteStream | null;
      audio: RemoteStream | null;
      microphone: LocalStream | null;
      camera: LocalStream | null;
    };
  }
}

/** Milliseconds since the visitor has used the page for which it counts as used. */
const IN_USE = 15_000;

/** Milliseconds between two tokens of a gateway that gives its page some, well within the time of one. */
const TOKEN_RENEWAL = 20 * 60_000;

const canStream = "RTCPeerConnection" in globalThis;
const codecs = canStream ? decodableCodecs("video") : [];

const token = new PageToken(sessionStorage);
// Before anything reads the address.
token.readFrom(location, history);
let unwelcome: Unwelcome | null = null;
/** The token with which the page was let in last. */
let welcomed: string | undefined;
const client = new Client("./", { token: () => token.value });
const receiver = new MediaReceiver(client, { input: true });
let before = recall(sessionStorage, Date.now());
const directory = new BodyDirectory(client, bodyChanged, before?.engineId);
const header = new Header(directory, () => others.offered);
const banner = new Banner(() => client.retryNow(), takeToken);
const scene = byRole("scene", HTMLElement);
const stage = new Stage(scene);
const captions = new Captions(client);
const sound = new Sound();
const videoCard = new StreamCard("video");
const audioCard = new StreamCard("audio");
const readings = new Readings();
new FiguresPanel(readings);
const overlay = new Overlay(readings);
const say = new SayLine(client, (cut) => void window.openrois.audio?.hush(cut));
const reactions = new Reactions(client);
const gaze = new Gaze(client, stage.element);
const activity = new Activity(document);
/** What is taken over for a time is kept while the visitor does something, and a little longer. */
const isUsed = (): boolean => activity.within(IN_USE);
const body = new BodyControl(client, controlChanged, isUsed);
const parts = new PartsPanel(body);
// With tokens, the page sends sound and pictures while it has control, or by the role visitor.
const needsControl = (): boolean => token.counts && !token.visits;
const operator = new OperatorCard(client, receiver, () =>
  needsControl() ? body.takeControl() : Promise.resolve(() => undefined),
);
const map = new MapCard(client, byRole("card-map", HTMLElement), "map");
const control = new Control(client, receiver, body, stage.video, scene);
const handover = new Handover(body, (giveBack) => control.drive(giveBack), document);
const stopButton = new StopButton(client, () => say.stop());
const stoppedBodies = new StoppedBodies(client, () => stoppedNote.render());
const stoppedNote = new StoppedNote(stoppedBodies);
body.onLost = (why) => {
  control.controlLost(why);
  if (needsControl()) operator.off(why);
};
operator.onChange = () => {
  const words = needsControl() ? operator.sending : "";
  handover.held = words && `${words}: you have control`;
};
const dialogue = new DialogueCard(client, {
  microphone: () => operator.microphone,
  microphoneBarred: () => operator.microphoneBarred,
  visitorRef: () => operator.visitorRef,
  missing: (purposes) => operator.missing(purposes),
  consentTo: (purposes) => operator.consentTo(purposes),
  speaker,
});
operator.onConsent = () => dialogue.render();
new MessageLog(client);

let shown: PageBody | null = null;
window.openrois = { client, video: null, audio: null, microphone: null, camera: null };
const views = new Views(client, render);
const others = new OtherBodies(client, receiver, isUsed, (engineId) => directory.choose(engineId));
if (before?.muted === true) sound.muted = true;
overlay.shown = before?.statistics ?? false;
if (before && before.picture !== "") void stage.picture.restore(before.picture).then(render, () => undefined);

/** The visitor has pasted a token: the next attempt shows it at once. */
function takeToken(text: string): boolean {
  if (!token.give(text)) return false;
  client.retryNow();
  return true;
}

/** Finds out why there is no connection; a gateway that refuses the page is asked again with another token only. */
async function askWhy({ state } = client): Promise<void> {
  if (state.name === "connected") {
    unwelcome = null;
    welcomed = token.value;
    if (welcomed !== undefined) await askWhetherItCounts(welcomed);
  }
  if (state.name !== "waiting" || state.retryAt === Infinity) return;
  // A gateway that gives its page tokens knows none of those that it gave before it was started again.
  const isAnother = await token.obtain();
  if (client.state !== state) return;
  if (isAnother) return client.retryNow();
  const shown = token.value;
  const away = await isTurnedAway(shown);
  if (client.state !== state || token.value !== shown) return;
  const ended = shown === welcomed || token.hasEnded(Date.now());
  unwelcome = !away ? null : shown === undefined ? "none" : ended ? "ended" : "refused";
  if (away) {
    operator.off("");
    client.hold();
  }
  render();
}

/** Finds out whether the token counts: it may be left from when the gateway asked for one. */
async function askWhetherItCounts(shown: string): Promise<void> {
  const asked = await asksForTokens(shown);
  if (token.asked === asked) return;
  token.asked = asked;
  bodyChanged();
}

/** Updates all panels: the profile was read, another body was chosen, or the connection has changed. */
function bodyChanged(): void {
  const chosen = directory.chosen;
  if (chosen && chosen.engineId !== shown?.engineId) show(chosen);
  const present = directory.present && client.state.name === "connected" ? chosen : null;
  say.offered = chosen?.speech !== null;
  reactions.offered = chosen?.reaction !== null;
  say.setComponents(present?.speech ?? null, present?.progress ?? null);
  captions.setComponent(present?.progress ?? null);
  reactions.setComponent(present?.reaction ?? null);
  map.setBody(present);
  control.setComponent(present?.teleoperation ?? null);
  dialogue.setBody(present);
  body.ranked = say.ranked = token.ranks;
  body.setComponents(present && movingParts(present), present?.speech ? [present.speech] : []);
  const all = client.state.name === "connected" ? (directory.bodies ?? []) : [];
  const watching = token.mayOperate ? "" : WATCHING;
  others.update(all, chosen?.engineId ?? "", { watching, ranked: token.ranks });
  const acting = [...(present ? [present] : []), ...others.carded].map(actingBody);
  stopButton.setBodies(acting);
  stoppedBodies.setBodies(acting);
  controlChanged();
  if (present) {
    void readClock(present);
    void operator.watch(present).then((streams) => {
      Object.assign(window.openrois, streams);
      streams.microphone?.on("change", () => dialogue.render());
      dialogue.render();
    });
  }
  views.update(directory.listing, client.state.name === "connected");
  render();
}

/** Names the one that speaks through the body now: this page, the holder of its voice, or the body itself. */
function speaker(): string {
  const name = shown?.engineId ?? "";
  const holder = say.speaking ? "you" : amid(body.holderOf(shown?.speech ?? null));
  return holder === "" ? name : `${name}, by ${holder}`;
}

function actingBody(one: PageBody): ActingBody {
  return { engineId: one.engineId, acting: [...(one.speech ? [one.speech] : []), ...movingParts(one)] };
}

/** Updates what may be used, after a change of control; disabled controls say why. */
function controlChanged(): void {
  const present = directory.present && client.state.name === "connected" ? directory.chosen : null;
  const watching = token.mayOperate ? "" : WATCHING;
  const why = (ref: string | null): string => {
    const holder = body.holderOf(ref);
    return watching || (holder && `${holder} has control`);
  };
  const operated = present && (movingParts(present)[0] ?? null);
  const { hindrance } = body;
  const taken = watching || (hindrance && `${hindrance} has control`);
  for (const part of [say, stopButton]) part.barred = watching;
  control.barred = taken;
  reactions.barred = why(present?.reaction ?? null);
  operator.barred = present === null ? AWAY : needsControl() ? taken : "";
  for (const card of [videoCard, audioCard]) card.present = present !== null;
  gaze.setComponent(why(present?.gaze ?? null) === "" ? (present?.gaze ?? null) : null);
  parts.mayOperate = watching === "";
  map.viewBarred = why(operated);
  map.barred = why(present?.navigation ?? null);
  handover.watching = watching !== "";
  stoppedNote.watching = watching !== "";
  handover.shown = present !== null;
}

/** Milliseconds since the last frame was shown; a picture that cannot be seen does not age. */
function frameAge(): number | null {
  const hidden = document.visibilityState !== "visible" || views.current !== "avatar";
  if (hidden || stage.frameAge === null) return null;
  return Math.min(stage.frameAge, performance.now() - views.since);
}

function show(chosen: PageBody): void {
  shown = chosen;
  const { video: oldVideo, audio: oldAudio } = window.openrois;
  // The picture of a body that is still there goes on in a card.
  const isThere = directory.bodies?.some(({ video }) => video === oldVideo?.componentRef) ?? false;
  if (!isThere || !others.hasCards) void oldVideo?.disconnect();
  void oldAudio?.disconnect();
  const video = chosen.video === null ? null : receiver.stream(chosen.video, "video");
  const audio = chosen.audio === null ? null : receiver.stream(chosen.audio, "audio");
  Object.assign(window.openrois, { video, audio });
  stage.watch(video);
  sound.listen(audio);
  videoCard.watch(video);
  audioCard.watch(audio);
  readings.watch(video, audio);
  video?.on("change", render);
  const past = before?.engineId === chosen.engineId ? before : null;
  before = null;
  if (video) begin(video, past?.video);
  if (audio) begin(audio, past?.audio);
}

/** Brings a stream into the state that it had when the page was left. */
function begin(stream: RemoteStream, desire: Desire = "running"): void {
  if (desire === "suspended") void stream.suspend();
  else if (desire === "running") void stream.connect();
}

async function readClock({ engineId, system }: PageBody): Promise<void> {
  if (isLoopback(location.hostname)) return void (readings.clock = SAME_CLOCK);
  const clock = system === null ? null : await measureOffset(client, system).catch(() => null);
  if (shown?.engineId === engineId) readings.clock = clock;
}

function render(): void {
  const { video } = window.openrois;
  const chosen = directory.chosen;
  header.render(client.state);
  parts.render();
  stage.render(directory.present, readings.latency);
  const visible = views.current === "avatar" && document.visibilityState === "visible";
  map.shown = visible;
  others.render(visible);
  const trouble = findTrouble({
    canStream,
    connection: client.state,
    unwelcome,
    streaming: client.extensions !== null,
    body:
      directory.bodies === null
        ? null
        : chosen === null
          ? "none"
          : { name: chosen.engineId, present: directory.present },
    codecs,
    video: {
      wanted: video?.desire === "running",
      problem: video?.problem ?? null,
      status: video?.status ?? null,
      frameAge: frameAge(),
    },
  });
  // Trouble of the avatar does not concern users of the inspector.
  const concerns =
    views.current === "avatar" || trouble?.kind === "no-gateway" || trouble?.kind === "no-token";
  banner.render(concerns ? trouble : null);
}

/** Keys that do something with the avatar do so while it is in view. */
function toAvatar(run: (key: string) => void): (key: string) => void {
  return (key) => {
    if (views.current === "avatar") run(key);
  };
}

installFullscreen();
installShortcuts([
  { keys: ["x"], label: "STOP: everything that moves", run: () => undefined },
  {
    keys: ["/"],
    label: "Say something, or search in the inspector",
    run: () => (views.current === "avatar" ? say.focus() : views.search()),
  },
  { keys: ["i"], label: "Inspector or body", run: () => views.toggle() },
  { keys: ["Escape"], label: "Stop speaking, and leave the text field", run: toAvatar(() => say.stop()) },
  {
    keys: ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0"],
    label: "Reactions",
    run: toAvatar((key) => reactions.press((Number(key) + 9) % 10)),
  },
  { keys: ["s"], label: "Suspend or resume the video", run: toAvatar(toggleVideo) },
  { keys: ["t"], label: "Your microphone on or off", run: toAvatar(() => operator.toggleMicrophone()) },
  { keys: ["c"], label: "Your camera on or off", run: toAvatar(() => operator.toggleCamera()) },
  { keys: ["k"], label: "Captions on or off", run: toAvatar(() => captions.toggle()) },
  { keys: ["m"], label: "Sound on or off", run: () => sound.toggle() },
  { keys: ["g"], label: "Statistics of the last minute", run: toAvatar(() => overlay.toggle()) },
  { keys: ["f"], label: "Full screen", run: toAvatar(toggleFullscreen) },
]);

function toggleVideo(): void {
  const { video } = window.openrois;
  if (!video || video.desire === "disconnected") return;
  void (video.desire === "suspended" ? video.resume() : video.suspend());
}

stage.frames.onFrame((frame) => readings.frameShown(frame));
client.on("state", bodyChanged);
client.on("state", () => void askWhy());
globalThis.addEventListener("hashchange", () => {
  const former = token.value;
  token.readFrom(location, history);
  if (token.value !== former) client.retryNow();
});
globalThis.addEventListener("online", () => {
  client.networkChanged();
  receiver.networkChanged();
});
document.addEventListener("visibilitychange", () => {
  if (document.visibilityState === "visible") client.retryNow();
  render();
});
globalThis.addEventListener("pagehide", () => {
  const { video, audio } = window.openrois;
  if (!shown) return;
  const page = {
    engineId: shown.engineId,
    video: video?.desire ?? "running",
    audio: audio?.desire ?? "running",
    muted: sound.muted,
    statistics: overlay.shown,
    picture: stage.picture.snapshot(960),
  };
  remember(sessionStorage, page, Date.now());
});
// The countdowns, and the age of the picture.
setInterval(render, 500);
render();
// The gateway ends a connection with its token: there is a newer one by then.
setInterval(() => void token.obtain(), TOKEN_RENEWAL);
void connect();

async function connect(): Promise<void> {
  if (token.value === undefined) await token.obtain();
  await client.connect();
}
