/** What the programs of this folder share: a client, a word about what was seen, a wait until the test says go on. */

import { createRequire } from "node:module";
import { createInterface } from "node:readline";

export const sdk = await import(`${process.env.OPENROIS_SDK}/index.js`);

const { WebSocket: WebSocketOfLibrary } = createRequire(`${process.env.WEB_DEMO}/package.json`)("ws");
const lines = createInterface({ input: process.stdin })[Symbol.asyncIterator]();

export const library = {
  webSocket: (url, protocols, headers) => new WebSocketOfLibrary(url, protocols, { headers }),
};

/** Node's own WebSocket where it has one, else that of `ws`. */
export const connect = async (options = {}) => {
  const client = new sdk.Client(process.argv[2], {
    ...("WebSocket" in globalThis ? {} : library),
    ...options,
  });
  await client.connect({ signal: AbortSignal.timeout(10_000) });
  return client;
};

export const say = (about, what) => console.log(JSON.stringify({ [about]: what ?? null }));

export const told = async () => {
  await lines.next();
};

export const end = async (client) => {
  await client.close();
  process.stdin.destroy();
};
