/** Shows a token with each WebSocket that Node has. */

import { connect, end, library, say } from "./application.mjs";

const token = `${process.env.TOKEN}\n`;
for (const [name, options] of Object.entries({ own: {}, ws: library })) {
  const client = await connect({ ...options, token });
  say(name, client.state.name);
  await end(client);
}
