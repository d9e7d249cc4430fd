// Two bodies and their visitors: one greets, another one guides, and whichever is free takes the next visitor.
// In a folder with the package, and before Node 22 with `ws`, too: node two_bodies.mjs
import { Client, Navigation, Reaction, RoISError, SpeechSynthesis } from "openrois";

const PLACE = "-1.0,0.5,0.0"; // x and y in metres, and the direction in radians, on the floor of each body
const WAIT = { waitMs: 120_000 }; // that visitors wait for a body
const ATTEMPTS = 5; // bodies that may be lost while they serve one visitor

const [url = "ws://127.0.0.1:8765/", ...visitors] = process.argv.slice(2);
const { WebSocket } = "WebSocket" in globalThis ? globalThis : await import("ws");
const client = new Client(url, { webSocket: (address, protocols) => new WebSocket(address, protocols) });

const say = (body, text) => body.component(SpeechSynthesis).perform({ speech_text: text });
const lead = (body) => body.component(Navigation).perform({ target_positions: [PLACE] });

async function withBody(types, work) {
  const body = await client.body(types, WAIT);
  try {
    return await work(body);
  } finally {
    await body.release();
  }
}

/** Lets one body greet with a gesture, and another one lead the way. */
const welcome = () =>
  withBody([SpeechSynthesis, Reaction], (host) =>
    withBody([SpeechSynthesis, Navigation], async (guide) => {
      const reaction = host.component(Reaction);
      const [gesture] = (await reaction.availableReactions()).available_reactions;
      await Promise.all([
        say(host, "Welcome! My colleague shows you the way."),
        reaction.perform({ reaction_ref: gesture }),
      ]);
      await Promise.all([say(guide, "Follow me, please."), lead(guide)]);
      console.log(`${host.engineId} greeted, ${guide.engineId} guided`);
    }),
  );

/** Serves a visitor with a body that is free; with another one when that is lost. */
async function receive(visitor) {
  for (let attempt = 1; ; attempt++) {
    const done = await withBody([SpeechSynthesis, Navigation], async (body) => {
      try {
        await Promise.all([say(body, `Good day, ${visitor}. Come with me.`), lead(body)]);
        console.log(`${visitor}: ${body.engineId} took care`);
        return true;
      } catch (error) {
        if (!(error instanceof RoISError) || attempt === ATTEMPTS) throw error;
        console.log(`${visitor}: ${body.engineId} was lost: ${error.message}`);
        return false;
      }
    });
    if (done) return;
  }
}

await client.connect();
try {
  await welcome();
  const names = visitors.length > 0 ? visitors : ["visitor 1", "visitor 2", "visitor 3"];
  await Promise.all(names.map(receive));
} finally {
  await client.close();
}
