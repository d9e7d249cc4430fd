/** What microphone and camera may be used for, in words. Pure. */

import type { Purpose } from "../../sdk/index.ts";

/** Every purpose with what it lets be done, in the order of the page. */
export const PURPOSE_WORDS: Readonly<Record<Purpose, string>> = {
  live: "Be heard and seen live",
  recognition: "Words and faces may be recognised",
  agent: "A program that answers may get them",
  recording: "They may be recorded",
  transfer: "They may go to another machine",
};

/** What a body did with them before it asked: that is chosen at first. */
export const AT_FIRST: readonly Purpose[] = ["live", "recognition"];

/** Says why nothing can be sent where nothing is consented to. */
export const NOTHING_CHOSEN = "Microphone and camera stay off until you choose what they may be used for";

const SHORT: Readonly<Record<Purpose, string>> = {
  live: "heard and seen live",
  recognition: "recognised",
  agent: "passed to a program that answers",
  recording: "recorded",
  transfer: "sent to another machine",
};

/** Says what is consented to while something is sent. */
export function consentWords(purposes: readonly Purpose[]): string {
  const words = purposes.map((purpose) => SHORT[purpose]);
  const last = words.pop();
  if (last === undefined) return "Nothing that you send is used.";
  return `You may be ${words.length > 0 ? `${words.join(", ")} and ${last}` : last}.`;
}

/**
 * Whether an event tells of this page: senses follow one visitor, which may be another one.
 *
 * @param visitorRef the visitor that the page is; empty while that is not known
 */
export function isOwn(told: { readonly visitor_ref?: string }, visitorRef: string): boolean {
  return told.visitor_ref === undefined || visitorRef === "" || told.visitor_ref === visitorRef;
}
