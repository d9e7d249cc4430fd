/** Has commands running when the gateway crashes, and says how each of them has ended. */

import { connect, end, say } from "./application.mjs";

const client = await connect({ backoff: { first: 50, max: 50 } });
const lamp = "robot/lamp";
while (!(await client.search()).includes(lamp)) await new Promise((resolve) => setTimeout(resolve, 20));
await client.bind(lamp);
const unit = (command_type) => ({ component_ref: lamp, command_type, arguments: [] });
const ids = await client.execute([unit("start"), unit("switch")]);
const ends = [...ids, "never sent"].map((id) =>
  client.completed(id).then(
    ({ status, reason }) => [status, reason],
    (error) => [error.constructor.name],
  ),
);
say("ready");
say("ended", await Promise.all(ends));
await end(client);
