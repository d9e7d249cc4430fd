/** Conditions: the subset of CQL2-Text that a gateway reads. The empty condition means everything. */

/** Returns `text` as a literal: in single quotes, with those inside it doubled. */
export const quote = (text: string): string => `'${text.replaceAll("'", "''")}'`;

/**
 * Returns the condition that all properties have these values: `where({ component_type: Navigation.componentType })`.
 *
 * @param properties `component_ref`, `component_type` (the URN of its type); `stream_id` in a query for a stream's status
 */
export const where = (properties: { readonly [property: string]: string }): string =>
  and(...Object.entries(properties).map(([property, value]) => `${property} = ${quote(value)}`));

/**
 * Returns the condition that a property is like a pattern, in which `%` stands for any text, `_` for any character and
 * a backslash takes the meaning from the character behind it: `like("component_ref", "robot/%")`.
 */
export const like = (property: string, pattern: string): string => `${property} LIKE ${quote(pattern)}`;

/** Returns `text` as a pattern that only this very text is like. */
export const escapeLike = (text: string): string => text.replace(/[%_\\]/g, "\\$&");

/** Returns the condition that all of these hold; empty ones are left out. */
export const and = (...conditions: readonly string[]): string =>
  conditions.filter((condition) => condition !== "").join(" AND ");

/** Returns the condition that names exactly one component. */
export const onlyComponent = (componentRef: string): string => where({ component_ref: componentRef });
