/** What other people are called. Pure. */

/** What a gateway without authentication calls every application. */
const WITHOUT_TOKEN = "local";

/** Names the subject of a token for a person; without tokens subjects have no names. */
export function named(subject: string, unknown = "Another visitor"): string {
  return subject === "" || subject === WITHOUT_TOKEN ? unknown : subject;
}
