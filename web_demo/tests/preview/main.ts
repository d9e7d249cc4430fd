/** The page with an avatar that lives in the browser itself: nothing has to run to work on the page. */

import { FakeGateway } from "../support/fake_gateway.ts";
import { PreviewAvatar } from "./avatar.ts";

const gateway = new FakeGateway();
const avatar = new PreviewAvatar(gateway, "avatar");

function openSocket(url: string, protocols: string[]): unknown {
  return gateway.webSocket(url, protocols);
}

Object.assign(globalThis, { WebSocket: openSocket, preview: { gateway, avatar } });
if (!location.hash.includes("alone")) avatar.arrive();
if (location.hash.includes("down")) gateway.running = false;
await import("../../app/main.ts");
