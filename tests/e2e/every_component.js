// Runs in the page: uses every component of the avatar by the TypeScript SDK, and returns what each of them gave.
// The page's camera shows a nodding person, and its microphone hears "go to the window".
// Tests give it what it shall not take longer than, in ms.
async (patience) => {
  const sdk = await import("/openrois.js");
  const { client } = openrois;
  const found = {};
  const told = {};

  const until = async (what, condition) => {
    const end = performance.now() + patience;
    for (;;) {
      const seen = await condition();
      if (seen) return seen;
      if (performance.now() > end) throw new Error(`not within ${patience} ms: ${what}; heard ${JSON.stringify(told)}`);
      await new Promise((resolve) => setTimeout(resolve, 40));
    }
  };
  const { component_profiles: profiles } = await client.getProfile();
  // The standard's classes by type, and what is ours by its profile.
  const part = (name) => {
    const ref = `avatar/${name}`;
    const Part = sdk[sdk.componentType(profiles[ref])] ?? sdk.ComponentProxy;
    return new Part(client, ref);
  };
  const subscriptions = [];
  const hear = async (name, event) => {
    const all = (told[`${name}.${event.eventType}`] = []);
    subscriptions.push(await event.subscribe((payload) => all.push(payload)));
    return all;
  };
  const heard = (all, what, condition) => until(what, () => all.find(condition));
  const where = async () => {
    const { position_data } = await information.robotPosition();
    return position_data[0].split(",").map(Number);
  };
  const ended = async (work) => {
    try {
      await work;
      return "OK";
    } catch (error) {
      return error.status ?? String(error);
    }
  };

  const information = part("system_info");
  found.system_info = { status: (await information.engineStatus()).status, began: await where() };

  const streams = async () => {
    for (const [name, stream] of [["video_streaming", openrois.video], ["audio_streaming", openrois.audio]]) {
      const status = await part(name).componentStatus();
      const parameters = await part(name).getParameter();
      await stream.suspend();
      const suspended = await until(`${name} is suspended`, () => stream.status.endsWith("SUSPENDED") && stream.status);
      await stream.resume();
      await until(`${name} runs again`, () => stream.status === "STREAMING_RUNNING");
      found[name] = { status: status.status, suspended, encodings: parameters.available_encodings };
    }
  };

  const eyes = async () => {
    const times = { timestamp: "DateTime" };
    const sight = part("sight");
    const seen = await hear("sight", sight.event("seen", { person_ref: "RoISIdentifier[]", box: "string[]", name: "string[]", gesture_ref: "RoISIdentifier[]", ...times }));
    const numbers = { person_detecter: "personDetected", face_detecter: "faceDetected" };
    for (const [name, event] of Object.entries(numbers)) {
      const all = await hear(name, part(name)[event]);
      found[name] = await heard(all, `${name} sees one`, ({ number }) => number === 1);
    }
    const places = { person_localizer: "personLocalized", face_localizer: "faceLocalized" };
    for (const [name, event] of Object.entries(places)) {
      const all = await hear(name, part(name)[event]);
      found[name] = await heard(all, `${name} tells a place`, ({ position_data }) => position_data.length === 1);
    }
    found.sight = await heard(seen, "a face is to be drawn", ({ person_ref }) => person_ref.length === 1);

    const known = await hear("person_identifier", part("person_identifier").personIdentified);
    const enrolment = part("enrolment");
    await enrolment.bound(async () => {
      // Who is hardly seen, because the machine is busy, tries again.
      const enrol = () => enrolment.obtain("enrol", { person_ref: "RoISIdentifier" }, sdk.encode({ name: "string" }, { name: "Ann" }));
      const person = await until("Ann is enrolled", () => enrol().catch((error) => void (told.enrol = String(error))));
      found.person_identifier = await heard(known, "Ann is recognised", ({ person_ref }) => person_ref.length === 1);
      const { names } = await enrolment.query("enrolled", { names: "string[]" });
      await enrolment.execute("forget", sdk.encode({ name: "string" }, { name: "Ann" }));
      const { names: left } = await enrolment.query("enrolled", { names: "string[]" });
      found.enrolment = { ...person, names, left };
    });
    const gestures = await hear("gesture_recognizer", part("gesture_recognizer").gestureRecognized);
    const each = { visitor_ref: "RoISIdentifier[]", devices: "string[]", consent: "string[]", attended: "RoISIdentifier" };
    found.visitors = await part("visitors").query("visitors", each);
    found.gesture_recognizer = await heard(gestures, "a nod", () => true);
  };

  const ears = async () => {
    const recognition = part("speech_recognizer");
    const { languages } = await recognition.recognizableLanguages();
    await recognition.setParameter({
      grammar: "#JSGF V1.0;\ngrammar g;\npublic <command> = go to the (window | door) | turn (left | right);\n",
    });
    const hearing = part("hearing");
    const words = await hear("hearing", hearing.event("heard", { text: "string", final: "bool", timestamp: "DateTime" }));
    const began = await hear("speech_recognizer", recognition.speechInputStarted);
    const stopped = await hear("speech_recognizer", recognition.speechInputFinished);
    const said = await hear("speech_recognizer", recognition.speechRecognized);
    const sounds = await hear("sound_detecter", part("sound_detecter").soundDetected);
    const faults = [];
    client.on("fault", ({ error_id }) => faults.push(error_id));
    await hear("sound_localizer", part("sound_localizer").soundLocalized);
    const { recognized_text } = await heard(said, "what is said", () => true);
    found.speech_recognizer = { languages, recognized_text, began: began.length, stopped: stopped.length };
    const final = await heard(words, "the last word", ({ final }) => final);
    const { channels } = await hearing.query("microphone", { channels: "int", speaking: "bool" });
    found.hearing = { ...final, channels };
    await heard(sounds, "silence after the sound", ({ number }) => number === 0);
    found.sound_detecter = sounds.map(({ number }) => number);
    await until("a word on the one channel", () => faults.length > 0);
    found.sound_localizer = { fault: (await client.getErrorDetail(faults[0])).map(({ value }) => value) };
    const operator = part("operator");
    const level = { rms: "double", peak: "double" };
    const loud = await hear("operator", operator.event("microphone_level", level));
    await heard(loud, "a loud microphone", ({ rms }) => rms > -50);
    found.operator = {
      ...(await operator.query("microphone", { connected: "bool", ...level })),
      ...(await operator.query("camera", { width: "int", height: "int", brightness: "double" })),
    };
  };

  const scene = async () => {
    const persons = await hear("scene_person_detecter", part("scene_person_detecter").personDetected);
    const people = await hear("scene_person_localizer", part("scene_person_localizer").personLocalized);
    const sounds = await hear("scene_sound_localizer", part("scene_sound_localizer").soundLocalized);
    found.scene_person_detecter = await heard(persons, "the visitor is counted", () => true);
    found.scene_person_localizer = await heard(people, "the visitor is somewhere", () => true);
    found.scene_sound_localizer = await heard(sounds, "the radio is somewhere", () => true);
    const surroundings = part("surroundings");
    found.surroundings = {
      ...(await surroundings.query("floor", { outline: "string[]", obstacles: "string[][]" })),
      ...(await surroundings.query("things", { thing_ref: "RoISIdentifier[]", kind: "string[]", name: "string[]", position_data: "string[]" })),
    };
  };

  const voice = async () => {
    const speech = part("speech_synthesizer");
    const { languages } = await speech.synthesizableLanguages();
    const { characters: voices } = await speech.availableVoices();
    const progress = part("speech_progress");
    const words = await hear("speech_progress", progress.event("word_spoken", { word: "string", position: "int" }));
    const ends = await hear("speech_progress", progress.event("speech_ended", { status: "string" }));
    const asked = performance.now();
    const status = await ended(speech.perform({ speech_text: "Hello window, here I am.", language: "en" }));
    found.speech_synthesizer = { status, languages, voices, lasted: performance.now() - asked };
    const { status: end } = await heard(ends, "the end of the speech", () => true);
    const counts = { speeches: "int", taken: "int", dropped: "int", refused: "int", malformed: "int" };
    found.speech_stream = await new sdk.ComponentProxy(client, "avatar/speech_stream").query("streaming", counts);
    found.speech_progress = { words: words.map(({ word }) => word), end };
    const dialogue = part("dialogue");
    const changes = await hear("dialogue", dialogue.event("changed", { wake_word: "string" }));
    await dialogue.bound(async () => {
      await client.setParameter("avatar/dialogue", sdk.encode({ wake_word: "string" }, { wake_word: "computer" }));
      await heard(changes, "the wake word is told", ({ wake_word }) => wake_word === "computer");
    });
    // It holds for as long as the voice is held.
    found.dialogue = await heard(changes, "the wake word is taken back", ({ wake_word }) => wake_word === "");
  };

  const gestures = async () => {
    const reaction = part("reaction");
    const { available_reactions: reactions } = await reaction.availableReactions();
    found.reaction = { reactions, status: await ended(reaction.perform({ reaction_ref: reactions[0] })) };
    const gaze = part("gaze");
    await gaze.bound(async () => {
      found.gaze = await ended(gaze.execute("look", sdk.encode({ x: "double", y: "double" }, { x: 0.5, y: -0.5 })));
    });
    const viewpoint = part("viewpoint");
    const choose = (name) =>
      ended(viewpoint.execute("choose", sdk.encode({ viewpoint: "string" }, { viewpoint: name })));
    found.viewpoint = [await choose("face"), await choose("automatic")];
  };

  const legs = async () => {
    await hear("surroundings", part("surroundings").event("figure_moved", { position_data: "string" }));
    // On a very busy machine the dead man's switch stops what moves: then it goes on from there.
    const arriving = async (go) => {
      let status = await go();
      for (let tries = 0; status === "ABORT" && tries < 5; tries += 1) status = await go();
      return status;
    };
    const navigation = part("navigation");
    await arriving(() => ended(navigation.perform({ target_positions: ["0,0,-1.5708"] }))); // others have used the figure
    const ahead = async () => {
      const [, y] = await where();
      return ended(part("move").perform({ line: [Math.round(400 + 1000 * y), 0] }));
    };
    found.move = { status: await arriving(ahead), ended: await where() };
    const targets = await hear("navigation", navigation.reachedTarget);
    const there = { target_positions: ["-0.5,0,1.5708"], time_limit: 20_000 };
    const status = await arriving(() => ended(navigation.perform(there)));
    found.navigation = { status, ended: await where(), targets };
    const follow = part("follower");
    let following, over = true;
    const begin = async () => {
      over = false;
      following = ended(follow.perform({ target_object_ref: "stool", distance: 700 }));
      await following;
      over = true;
    };
    const stool = [-2.2, 0.5];
    const away = async () => {
      const [x, y] = await where();
      return Math.hypot(x - stool[0], y - stool[1]);
    };
    await until("the figure is as near to the stool as it is told", async () => {
      if (over) begin();
      return (await away()) < 0.71;
    });
    await follow.stop();
    found.follower = { status: await following, away: await away() };
  };

  try {
    await Promise.all([streams().then(voice), eyes(), ears(), scene(), gestures(), legs()]);
    found.surroundings.moved = told["surroundings.figure_moved"].length;
    return { found, components: Object.keys(profiles) };
  } finally {
    await Promise.all(subscriptions.map((each) => each.cancel()));
  }
}
