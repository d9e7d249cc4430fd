/** Every operation and every kind of message, once, on a robot with all basic components. */

import { connect, end, say, sdk } from "./application.mjs";

const client = await connect();
say("connected", { websocket: "WebSocket" in globalThis, extensions: client.extensions });

const { profile, component_profiles } = await client.getProfile();
say("profile", [
  profile.sub_profiles.map(({ identifier }) => identifier.code),
  Object.keys(component_profiles).length,
]);
say(
  "found",
  (await client.findAll(sdk.SpeechSynthesis, sdk.like("component_ref", "robot/%"))).map(
    (each) => each.componentRef,
  ),
);
say(
  "absent",
  await client
    .find(sdk.Navigation, sdk.where({ component_ref: "no'where" }))
    .catch((error) => error.returnCode),
);

const navigation = await client.find(sdk.Navigation);
say("unbound", await navigation.start().catch((error) => error.returnCode));
await navigation.bound(async () => {
  await navigation.setParameter({ target_positions: ["lobby", "café 'n'"], time_limit: 60_000 });
  say("parameters", await navigation.getParameter());
  const passed = [];
  const travelling = (async () => {
    for await (const { target, is_final_target } of navigation.reachedTarget) {
      passed.push(target);
      if (is_final_target) return;
      say("passed", target);
    }
  })();
  // The subscription is there when an event of it has come.
  while (passed.length === 0) await navigation.start();
  await travelling;
  say("travelled", passed);
});
say("status", await navigation.componentStatus());

const persons = await client.find(sdk.PersonDetection);
const detected = new Promise(
  (resolve) =>
    void persons.personDetected
      .subscribe((payload, event) => resolve([payload, event]))
      .then(() => persons.start()),
);
const [{ number, timestamp }, { event_id }] = await detected;
say("detected", { number, timestamp: timestamp.toISOString() });
say(
  "detail",
  (await client.getEventDetail(event_id)).map(({ name }) => name),
);

const speech = await client.find(sdk.SpeechSynthesis);
say("languages", await speech.synthesizableLanguages());
await speech.perform({ speech_text: "Hello!", volume: 70 });
say("robot", Object.keys(await (await client.find(sdk.SystemInformation)).robotPosition()));

const audio = await client.find(sdk.AudioStreaming);
const { stream_id } = await audio.connectStream();
await audio.suspendStream({ stream_id });
say("stream", [stream_id, await audio.getStreamStatus()]);
await audio.disconnectStream({ stream_id });

const follow = new sdk.Follow(
  client,
  await client.bindAny(sdk.where({ component_type: sdk.Follow.componentType })),
);
await follow.setParameter({ target_object_ref: "alice", distance: 800 });
const following = follow.start().catch((error) => [error.name, error.status]);
await follow.stop();
say("followed", await following);
await follow.release();

const sequence = await client.execute([
  { component_ref: persons.componentRef, command_type: "start" },
  {
    command_list: [
      { component_ref: audio.componentRef, command_type: "connect_stream" },
      { component_ref: persons.componentRef, command_type: "stop" },
    ],
  },
]);
say(
  "sequence",
  (await Promise.all(sequence.map((id) => client.completed(id)))).map(({ status }) => status),
);
say(
  "result",
  (await client.getCommandResult(sequence[1])).map(({ name }) => name),
);

const fault = new Promise((resolve) => client.on("fault", resolve));
say("ready", null);
const { error_id, error_type } = await fault;
say("fault", [error_type, sdk.resultValue(await client.getErrorDetail(error_id), "description") ?? null]);

say("unknown", await client.call("no.such.method", {}).catch((error) => [error.name, error.code]));
say(
  "wrong",
  await client.call("rois.command.bind", { component: 1 }).catch((error) => [error.name, error.code]),
);
let hear;
const heard = new Promise((resolve) => (hear = resolve));
const ended = (async () => {
  for await (const _ of persons.personDetected) hear();
  return "ended";
})();
// The reader's subscription is there when it has heard something.
let hears = false;
void heard.then(() => (hears = true));
while (!hears) await persons.start();
await end(client);
say("reader", await ended);
