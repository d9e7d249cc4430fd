/** Binds, subscribes and stays: what comes and goes around it is said. */

import { connect, end, say, sdk, told } from "./application.mjs";

const client = await connect({ backoff: { first: 50, max: 50 } });
const brief = (claim) => [claim.kind, ...(claim.error ? [claim.error.returnCode] : [])];
client.on("lost", (claim) => say("lost", brief(claim)));
client.on("restored", (claim) => say("restored", brief(claim)));
client.on("state", ({ name }) => {
  if (name === "waiting" || name === "connected") say(name);
});

const navigation = new sdk.Navigation(client, "robot/navigation");
await navigation.bind();
await navigation.setParameter({ target_positions: ["lobby"] });
await navigation.reachedTarget.subscribe(({ target }) => say("reached", target));
say("ready");
for (let round = 0; round < 3; round++) {
  await told();
  await navigation.setParameter({ target_positions: [`place ${round}`] });
  await navigation.start();
}
await told();
await end(client);
