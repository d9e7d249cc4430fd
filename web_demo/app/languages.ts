/** The languages of a voice, named for people. Pure. */

export interface LanguageOption {
  readonly tag: string;
  readonly name: string;
}

/**
 * Returns the languages by name, and which of them to select: the one chosen before, else English, which every voice
 * of ours begins with, else the reader's own, else the first.
 */
export function languageChoice(
  tags: readonly string[],
  chosen: string,
  preferred: readonly string[],
): { options: LanguageOption[]; selected: string } {
  const options = [...new Set(tags)]
    .map((tag) => ({ tag, name: languageName(tag) }))
    .sort((a, b) => a.name.localeCompare(b.name));
  const wanted = [
    chosen,
    ...preferred.filter((tag) => tag.startsWith("en")),
    "en",
    "en-US",
    "en-GB",
    ...preferred,
  ];
  const selected = wanted.find((tag) => options.some((option) => option.tag === tag));
  return { options, selected: selected ?? options[0]?.tag ?? "" };
}

function languageName(tag: string): string {
  try {
    return new Intl.DisplayNames(["en"], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}
