/** What is wrong, in words for the visitor, and what to do about it. Pure. */

import type { ConnectionState, StreamStatus } from "../../sdk/index.ts";
import type { Problem } from "../../sdk/media/index.ts";
import { plainReason } from "./plain_words.ts";

/** Why a page is refused. `none`: no token; `ended`: its token has ended; `refused`: its token is not valid. */
export type Unwelcome = "none" | "ended" | "refused";

export interface Situation {
  /** The browser has WebRTC. */
  readonly canStream: boolean;
  readonly connection: ConnectionState;
  /** Why the gateway refuses the page; null where it does not, or where that is unknown. */
  readonly unwelcome: Unwelcome | null;
  /** The gateway has the streaming extension; false for one that speaks plain RoIS. */
  readonly streaming: boolean;
  /** Null while the profile has not been read. */
  readonly body: { readonly name: string; readonly present: boolean } | "none" | null;
  /** The video codecs that the browser decodes. */
  readonly codecs: readonly string[];
  readonly video: {
    readonly wanted: boolean;
    readonly problem: Problem | null;
    readonly status: StreamStatus | null;
    /** Milliseconds since the last frame was shown; null before the first. */
    readonly frameAge: number | null;
  };
}

export interface Trouble {
  readonly kind:
    | "no-webrtc"
    | "no-gateway"
    | "no-token"
    | "no-streaming"
    | "no-adapter"
    | "adapter-gone"
    | "no-codec"
    | "no-media"
    | "refused"
    | "stalled";
  readonly title: string;
  readonly text: string;
  /** When the next try starts by itself, in milliseconds since the epoch; 0 while it runs. */
  readonly retryAt?: number;
}

/** A picture that is older than this, in milliseconds, although the stream runs, has stopped. */
export const STALLED_AFTER = 2500;

const USABLE_CODECS = ["video/h264", "video/vp8"];

const TOKEN_WORDS: Readonly<Record<Unwelcome, Pick<Trouble, "title" | "text">>> = {
  none: {
    title: "The gateway asks for a token",
    text: "Paste the one that you were given. It stays in this tab, until the tab is closed or the token ends.",
  },
  ended: {
    title: "Your token has ended",
    text: "Its time is over, or it was revoked; microphone and camera are off. Paste a new one to go on.",
  },
  refused: {
    title: "The gateway does not take this token",
    text: "It may have ended, be revoked or be for another gateway, or a part of it is missing. Paste another one.",
  },
};

/** Returns the trouble to solve first; null when all is well or still starting. */
export function findTrouble(situation: Situation): Trouble | null {
  return connectionTrouble(situation) ?? bodyTrouble(situation) ?? streamTrouble(situation);
}

function connectionTrouble({ canStream, connection, unwelcome, streaming }: Situation): Trouble | null {
  if (!canStream) {
    return {
      kind: "no-webrtc",
      title: "This browser has no WebRTC",
      text: "Live pictures need it. Use a current Chrome, Edge, Firefox or Safari, or allow WebRTC in the settings.",
    };
  }
  if (connection.name === "waiting" || (connection.name === "connecting" && connection.attempt > 0)) {
    if (unwelcome) return { kind: "no-token", ...TOKEN_WORDS[unwelcome] };
    return {
      kind: "no-gateway",
      title: "The gateway does not answer",
      text: "Start it with “openrois demo”, or look at the terminal where it ran. The page connects by itself.",
      retryAt: connection.name === "waiting" ? connection.retryAt : 0,
    };
  }
  if (connection.name === "connected" && !streaming) {
    return {
      kind: "no-streaming",
      title: "This gateway cannot stream",
      text: "It knows RoIS, but not the streaming extension. Speech and reactions may work; for the picture, run an OpenRoIS gateway.",
    };
  }
  return null;
}

function bodyTrouble({ connection, body }: Situation): Trouble | null {
  if (connection.name !== "connected" || body === null) return null;
  if (body === "none") {
    return {
      kind: "no-adapter",
      title: "No avatar or robot is connected",
      text: "The gateway runs, but nothing that it knows can be seen, heard or moved here. Start an avatar with “openrois avatar”, or a robot with “openrois robot”; it appears here by itself. Other components are in the Inspector.",
    };
  }
  if (body.present) return null;
  return {
    kind: "adapter-gone",
    title: `“${body.name}” has left`,
    text: "It has stopped, or lost the gateway. When it is started again (an avatar with “openrois avatar”, a robot with “openrois robot”), everything goes on by itself.",
  };
}

function streamTrouble({ connection, body, codecs, video }: Situation): Trouble | null {
  if (connection.name !== "connected" || body === null || !video.wanted) return null;
  if (!codecs.some((codec) => USABLE_CODECS.includes(codec.toLowerCase()))) {
    return {
      kind: "no-codec",
      title: "This browser decodes neither H.264 nor VP8",
      text: "The body sends one of these. Install the browser's media codecs, or use another browser.",
    };
  }
  if (video.problem) return problemTrouble(video.problem);
  const stopped = video.frameAge !== null && video.frameAge > STALLED_AFTER;
  if (video.status !== "STREAMING_RUNNING" || !stopped) return null;
  return {
    kind: "stalled",
    title: "The picture has stopped",
    text: "The body still sends, but nothing arrives. Another way through the network is being looked for.",
  };
}

function problemTrouble(problem: Problem): Trouble {
  switch (problem.kind) {
    case "no-media":
      return {
        kind: "no-media",
        title: "The picture does not get through",
        text: "The body is connected, but its video packets do not arrive. A firewall or VPN may block UDP between this browser and the body: allow it, or set up a TURN server at the gateway. Other ways are being tried.",
      };
    case "no-streaming":
      return {
        kind: "no-streaming",
        title: "This gateway cannot stream",
        text: "It has no streaming, or an older one. Run an OpenRoIS gateway of this version.",
      };
    case "unsupported":
      return {
        kind: "no-codec",
        title: "The body cannot send what this browser plays",
        text: `${said(problem.detail) ?? "They have no video codec in common, or the body has no video right now."} The page goes on trying.`,
      };
    case "refused":
      return {
        kind: "refused",
        title: "The body refuses the video",
        text: `${said(problem.detail) ?? "The log of its adapter tells why."} The page goes on trying.`,
      };
  }
}

/** The engine's own words; null where it gave a return code and nothing else. */
function said(detail: string): string | null {
  const why = plainReason(detail);
  return why === "" ? null : `It says: “${why}”.`;
}
