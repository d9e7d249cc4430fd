/** What is said of the machines that texts and the microphone's sound are sent to. Pure. */

export interface Recognizer {
  /** Where sound is sent to be recognised, as `https://host`; empty where it stays with the body. */
  readonly sent_to: string;
  /** Whether it may be sent there: of a visitor, where that one agrees, too. */
  readonly allowed: boolean;
}

/**
 * Returns a sentence for the person who speaks; nothing where the sound stays with the body.
 *
 * @param agrees whether that person agrees to another machine, as far as the body asks for that
 */
export function sentToWords(recognizer: Recognizer | null, agrees: boolean): string {
  if (recognizer === null || recognizer.sent_to === "") return "";
  return recognizer.allowed && agrees
    ? `To be written down, what you say is sent to ${recognizer.sent_to}.`
    : `Nothing is written down: what you say would be sent to ${recognizer.sent_to}, and you have not agreed to that.`;
}

/** Returns a sentence for the person who speaks to a program that answers; nothing where words stay on its machine. */
export function wordsSentToWords(sentTo: string, agrees: boolean): string {
  if (sentTo === "") return "";
  return agrees
    ? `To be answered, what you say is sent to ${sentTo}.`
    : `To be answered, what you say would be sent to ${sentTo}, and you have not agreed to that.`;
}

/** Returns a sentence for the person who types a text; nothing where it stays with the body. */
export function textsSentToWords(sentTo: string): string {
  return sentTo === "" ? "" : `To be spoken, texts are sent to ${sentTo}.`;
}
