/** Follows the directory, with a subscription at each of two robots: what changes, and what is renewed, is said. */

import { connect, end, library, say, sdk, told } from "./application.mjs";

const client = await connect(library);
const asked = [];
client.on("traffic", ({ kind, method, message }) => {
  if (kind === "request") asked.push([method, message.params]);
});
const requests = (name) => asked.filter(([method]) => method === name).map(([, params]) => params);

for (const robot of ["a", "b"]) {
  const navigation = new sdk.Navigation(client, `${robot}/navigation`);
  await navigation.reachedTarget.subscribe(() => undefined);
}
const subscribed = requests("rois.event.subscribe").length;
const engines = await client.engines();
say("engines", [...engines.keys()].sort());
const components = ["a", "b"].flatMap((robot) => engines.get(robot).components);
const profiles = await client.profiles(components);
say("profiles", [components.length, profiles.size, requests("openrois.directory.profiles").length]);
say(
  "same",
  JSON.stringify(sdk.bodiesOf(engines).map(({ engineId, components: parts }) => [engineId, ...parts])) ===
    JSON.stringify(
      sdk.bodiesIn(await client.getProfile()).map(({ engineId, components: parts }) => [engineId, ...parts]),
    ),
);

const renewed = new Promise((resolve) =>
  client.on("restored", ({ kind, condition }) => kind === "subscription" && resolve(condition)),
);
client.on("profile_changed", ({ engineIds }) => say("changed", [...engineIds]));
say("ready");
await told();
say("left", [...(await client.engines()).keys()].sort());
await told();
say("back", [...(await client.engines()).keys()].sort());
say("restored", await renewed);
const again = requests("rois.event.subscribe").slice(subscribed);
say("renewed", [...new Set(again.map(({ condition }) => condition))]);
say("lists", requests("openrois.directory.list").length);
await end(client);
