/** Reasons why a control cannot be used now: the token, or another visitor in control. */

export const WATCHING = "You are watching: your token does not let you operate the body";

/** What the visitor of this page may do. */
export interface Rights {
  /** Why it may only watch; empty where it may operate. */
  readonly watching: string;
  /** Whether its token names a rank that counts. */
  readonly ranked: boolean;
}

export const AWAY = "The body is away";

/** Id of the element with the reason, which screen readers read for a disabled control. */
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
