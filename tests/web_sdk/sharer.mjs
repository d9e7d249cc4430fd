/** A program and a person share a robot: one lends what it has bound, the other borrows it and gives it back. */

import { connect, end, say, sdk } from "./application.mjs";

const REF = "robot/navigation";
const [scripted, personal] = process.env.TOKEN.split(" ");
const program = await connect({ token: scripted });
const person = await connect({ token: personal });
const next = (client, name) => new Promise((resolve) => (client.on(name, resolve), undefined));
const reasonOf = (work) =>
  work.then(
    () => "",
    ({ returnCode, reason }) => [returnCode, reason],
  );

const navigation = new sdk.Navigation(program, REF);
await navigation.bind();
const lent = next(program, "lent");
const { state, lender, part } = await person.control.borrow(REF, { seconds: 20 });
say("borrowed", [state, lender, part]);
const { holder, returnMs } = await lent;
say("lent", [holder, returnMs > 0 && returnMs <= 20_000]);
say("refused", await reasonOf(navigation.start()));
say("of higher rank", (await reasonOf(program.control.borrow(REF)))[0]);
const restored = next(program, "restored");
await person.control.giveBack(REF);
say("restored", (await restored).componentRef);
await navigation.setParameter({ target_positions: ["lobby"] });
await navigation.start();

const voice = new sdk.SpeechSynthesis(program, "robot/speech_synthesizer");
await voice.bind();
const silenced = next(program, "lent");
await person.control.borrow(voice.componentRef, { forOneCommand: true });
await silenced;
const back = next(program, "restored");
await new sdk.SpeechSynthesis(person, voice.componentRef).perform({ speech_text: "Excuse me." });
say("restored", (await back).componentRef);
await voice.perform({ speech_text: "I go on." });
await end(person);
await end(program);
