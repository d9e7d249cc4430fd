/** Speaking where another application has the voice: it is taken from one of lower rank for that sentence. */

import { CommandFailed, RoISError } from "../../sdk/index.ts";
import type { Control, SpeechSynthesis } from "../../sdk/index.ts";

/** What the loan is made with. */
type Lending = Pick<Control, "borrow" | "giveBack" | "unlessStopped">;

/**
 * Speaks to the end.
 *
 * @param speech is bound for that, or taken where it is another application's
 * @param ranked whether this page's token names a rank that counts: without one nothing can be taken
 * @param signal says that it was stopped: what the voice is still to be taken for is not said then
 * @throws what `perform` throws | RoISError (OUT_OF_RESOURCES: the other application does not rank lower)
 */
export async function speak(
  control: Lending,
  speech: Pick<SpeechSynthesis, "componentRef" | "perform">,
  parameters: Parameters<SpeechSynthesis["perform"]>[0],
  ranked: boolean,
  signal: AbortSignal,
): Promise<void> {
  try {
    return await speech.perform(parameters);
  } catch (error) {
    if (!ranked || !(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) throw error;
  }
  const ref = speech.componentRef;
  const giveBack = (): Promise<void> => control.giveBack(ref).catch(() => undefined);
  await control.unlessStopped(ref, () => control.borrow(ref, { forOneCommand: true }), giveBack);
  try {
    if (signal.aborted) throw new CommandFailed("speech", "", "ABORT", "it was stopped before it began");
    await speech.perform(parameters);
  } finally {
    // Of what was begun it has gone back by itself; what was not begun, or had become free, has to be given back.
    await giveBack();
  }
}
