/** What a person who may only watch cannot use: it stays in view, and says why it cannot be used. */

export const WATCHING = "You are watching: your token does not let you operate the avatar";

/** The words that stand on the page all the time, for those who hear what they cannot use. */
const REASON = "handover-words";

/** Says of a control whether only the token is in the way; whether it can be used otherwise is its owner's to say. */
export function explain(control: HTMLElement, barred: boolean): void {
  const { dataset, title } = control;
  if (barred === (dataset["barred"] !== undefined)) return;
  if (barred) {
    dataset["barred"] = title;
    control.title = WATCHING;
    control.setAttribute("aria-describedby", REASON);
  } else {
    control.title = dataset["barred"] ?? "";
    delete dataset["barred"];
    control.removeAttribute("aria-describedby");
  }
}
