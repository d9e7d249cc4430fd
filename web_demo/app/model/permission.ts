/** What a person cannot use now, because of the token or because another visitor has control: it says why. */

export const WATCHING = "You are watching: your token does not let you operate the avatar";

export const AWAY = "The avatar is away";

/** The words that stand on the page all the time, for those who hear what they cannot use. */
const REASON = "handover-words";

/**
 * Says of a control why it cannot be used; its owner disables it.
 *
 * @param why in a sentence; empty where it can be used, as far as permission goes
 */
export function explain(control: HTMLElement, why: string): void {
  const { dataset } = control;
  if (why === "") {
    if (dataset["barred"] === undefined) return;
    control.title = dataset["barred"];
    delete dataset["barred"];
    control.removeAttribute("aria-describedby");
    return;
  }
  dataset["barred"] ??= control.title;
  control.title = why;
  control.setAttribute("aria-describedby", REASON);
}
