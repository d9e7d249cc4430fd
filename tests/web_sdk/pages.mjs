/** Two pages without documents, and a program, share a robot: what the page knows of control, at a real gateway. */

import { BodyControl } from "../../web_demo/app/model/body_control.ts";
import { Client } from "../../web_demo/sdk/index.ts";
import { end, library, say } from "./application.mjs";

const REFS = ["robot/navigation", "robot/move", "robot/follower", "robot/reaction"];
const VOICE = "robot/speech_synthesizer";
const [scripted, ...personal] = process.env.TOKEN.split(" ");

const connected = async (token) => {
  const client = new Client(process.argv[2], { ...library, token });
  await client.connect();
  return client;
};
const program = await connected(scripted);
const back = () => new Promise((resolve) => (program.on("restored", resolve), undefined));
await program.bind("robot/move");

const open = async (token) => {
  const page = { client: await connected(token), changed: [], lost: [] };
  page.body = new BodyControl(page.client, () => page.changed.splice(0).forEach((check) => check()));
  page.body.ranked = true;
  page.body.onLost = (why) => page.lost.push(why);
  page.body.setComponents(REFS, [VOICE]);
  return page;
};
/** Waits until the page knows that a part is someone's, and says what it knows of all. */
const until = async ({ body, changed }, name, fits) => {
  const part = () => body.parts.find((each) => each.name === name);
  while (!part() || !fits(part())) await new Promise((resolve) => changed.push(resolve));
  return body.parts.map(({ name, state, holder, lender }) => [name, state, holder, lender].join(" ").trim());
};

const ann = await open(personal[0]);
const bob = await open(personal[1]);
const isProgram = ({ holder }) => holder === "night watch";
say("before", [await until(ann, "legs", isProgram), ann.body.state.mayTakeOver]);

const giveBack = await ann.body.takeOver();
say("mine", await until(ann, "legs", ({ lender }) => lender === "night watch"));
// Each part is notified by itself.
await until(bob, "legs", ({ lender }) => lender === "night watch");
say("seen by another", await until(bob, "gesture", ({ holder }) => holder === "ann"));
await bob.body.takeOver().catch(({ message }) => say("refused", message));
say("to be asked", bob.body.state.mayTakeOver);
await ann.client.bound("robot/navigation", async () => undefined);
say("still", await until(ann, "legs", ({ state }) => state === "mine"));

let restored = back();
giveBack();
say("restored", (await restored).componentRef);
say("after", await until(bob, "legs", isProgram));

await until(ann, "legs", isProgram);
await ann.body.takePart(ann.body.parts[0]);
say("one part", await until(bob, "legs", ({ holder }) => holder === "ann"));
restored = back();
await ann.client.close();
say("restored", (await restored).componentRef);
say("lost", ann.lost);
await bob.client.close();
await end(program);
