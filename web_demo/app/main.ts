/** The page: wires the SDK to what a person sees. */

import { Client } from "../sdk/index.ts";
import {
  MediaReceiver,
  SAME_CLOCK,
  StampReader,
  decodableCodecs,
  isLoopback,
  measureOffset,
} from "../sdk/media/index.ts";
import type { RemoteStream } from "../sdk/media/index.ts";
import { AvatarDirectory } from "./avatars.ts";
import type { Avatar } from "./avatars.ts";
import { Banner } from "./banner.ts";
import { FiguresPanel } from "./figures.ts";
import { Gaze } from "./gaze.ts";
import { Header } from "./header.ts";
import { MessageLog } from "./log.ts";
import { Reactions } from "./reactions.ts";
import { SayLine } from "./say.ts";
import { installShortcuts } from "./shortcuts.ts";
import { Sound } from "./sound.ts";
import { Stage } from "./stage.ts";
import { StreamCard } from "./stream_card.ts";
import { findTrouble } from "./trouble.ts";
import { Views } from "./views.ts";

declare global {
  interface Window {
    /** For the browser's console and for tests: the client and the two streams of the page. */
    openrois: { client: Client; video: RemoteStream | null; audio: RemoteStream | null };
  }
}

const canStream = "RTCPeerConnection" in globalThis;
const codecs = canStream ? decodableCodecs("video") : [];

const client = new Client();
const receiver = new MediaReceiver(client);
const directory = new AvatarDirectory(client, avatarChanged);
const header = new Header(directory);
const banner = new Banner(() => client.retryNow());
const stage = new Stage();
const sound = new Sound();
const videoCard = new StreamCard("video");
const audioCard = new StreamCard("audio");
const figures = new FiguresPanel();
const say = new SayLine(client);
const reactions = new Reactions(client);
const gaze = new Gaze(client, stage.element);
new MessageLog(client);
new StampReader(stage.video, stage.frames, (reading) => figures.stampRead(reading));

let shown: Avatar | null = null;
window.openrois = { client, video: null, audio: null };
const views = new Views(client, render);

/** The profile was read, another avatar was chosen, or the gateway came or went. */
function avatarChanged(): void {
  const avatar = directory.chosen;
  if (avatar && avatar.engineId !== shown?.engineId) show(avatar);
  const present = directory.present && client.state.name === "connected" ? avatar : null;
  say.offered = avatar?.speech !== null;
  reactions.offered = avatar?.reaction !== null;
  say.setComponent(present?.speech ?? null);
  reactions.setComponent(present?.reaction ?? null);
  gaze.setComponent(present?.gaze ?? null);
  if (present) void readClock(present);
  views.update(directory.profile, client.state.name === "connected");
  render();
}

/** Milliseconds since the last frame was shown; a picture that nobody can see does not age. */
function frameAge(): number | null {
  const hidden = document.visibilityState !== "visible" || views.current !== "avatar";
  if (hidden || stage.frameAge === null) return null;
  return Math.min(stage.frameAge, performance.now() - views.since);
}

function show(avatar: Avatar): void {
  shown = avatar;
  const { video: oldVideo, audio: oldAudio } = window.openrois;
  void oldVideo?.disconnect();
  void oldAudio?.disconnect();
  const video = receiver.stream(avatar.video, "video");
  const audio = avatar.audio === null ? null : receiver.stream(avatar.audio, "audio");
  window.openrois = { client, video, audio };
  stage.watch(video);
  sound.listen(audio);
  videoCard.watch(video);
  audioCard.watch(audio);
  figures.watch(video);
  video.on("change", render);
  void video.connect();
  void audio?.connect();
}

async function readClock({ engineId, system }: Avatar): Promise<void> {
  if (isLoopback(location.hostname)) return figures.setClock(SAME_CLOCK);
  const clock = system === null ? null : await measureOffset(client, system).catch(() => null);
  if (shown?.engineId === engineId) figures.setClock(clock);
}

function render(): void {
  const { video } = window.openrois;
  const avatar = directory.chosen;
  header.render(client.state);
  stage.render(directory.present, figures.latency);
  const trouble = findTrouble({
    canStream,
    connection: client.state,
    streaming: client.extensions !== null,
    avatar:
      directory.avatars === null
        ? null
        : avatar === null
          ? "none"
          : { name: avatar.engineId, present: directory.present },
    codecs,
    video: {
      wanted: video?.desire === "running",
      problem: video?.problem ?? null,
      status: video?.status ?? null,
      frameAge: frameAge(),
    },
  });
  // What is wrong with the avatar is of no concern to whoever looks at the inspector.
  const concerns = views.current === "avatar" || trouble?.kind === "no-gateway";
  banner.render(concerns ? trouble : null);
}

/** Keys that do something with the avatar do so while it is in view. */
function toAvatar(run: (key: string) => void): (key: string) => void {
  return (key) => {
    if (views.current === "avatar") run(key);
  };
}

installShortcuts([
  {
    keys: ["/"],
    label: "Say something, or search in the inspector",
    run: () => (views.current === "avatar" ? say.focus() : views.search()),
  },
  { keys: ["i"], label: "Inspector or avatar", run: () => views.toggle() },
  { keys: ["Escape"], label: "Stop speaking, and leave the text field", run: toAvatar(() => say.stop()) },
  {
    keys: ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0"],
    label: "Reactions",
    run: toAvatar((key) => reactions.press((Number(key) + 9) % 10)),
  },
  { keys: ["s"], label: "Suspend or resume the video", run: toAvatar(toggleVideo) },
  { keys: ["m"], label: "Sound on or off", run: () => sound.toggle() },
  { keys: ["f"], label: "Full screen", run: toAvatar(() => stage.toggleFullscreen()) },
]);

function toggleVideo(): void {
  const { video } = window.openrois;
  if (!video || video.desire === "disconnected") return;
  void (video.desire === "suspended" ? video.resume() : video.suspend());
}

stage.frames.onFrame(() => figures.frameShown());
client.on("state", avatarChanged);
globalThis.addEventListener("online", () => client.retryNow());
document.addEventListener("visibilitychange", () => {
  if (document.visibilityState === "visible") client.retryNow();
  render();
});
// The countdowns, and the age of the picture.
setInterval(render, 500);
render();
void client.connect();
