/** The languages of a voice, named for people, and those that were chosen lately. Pure. */

export interface LanguageOption {
  readonly tag: string;
  readonly name: string;
}

export interface LanguageChoice {
  /** Those that were chosen lately, the newest first. */
  readonly recent: readonly LanguageOption[];
  /** All others, by name. */
  readonly others: readonly LanguageOption[];
  readonly selected: string;
}

/** What a browser keeps for the page's address, across tabs. */
type Store = Pick<Storage, "getItem" | "setItem">;

const KEY = "openrois.languages";
const RECENT = 4;

/** Tags that browsers name wrongly or not at all. */
const NAMES: Readonly<Record<string, string>> = {
  // A voice of a server speaks whatever the text is written in.
  mul: "Any language",
  ba: "Bashkir",
  bpy: "Bishnupriya",
  "ca-ba": "Catalan (Balearic)",
  "ca-nw": "Catalan (north-western)",
  "ca-va": "Catalan (Valencian)",
  "chr-us-qaaa-x-west": "Cherokee (western)",
  cv: "Chuvash",
  "en-gb-scotland": "English (Scotland)",
  "en-gb-x-gbclan": "English (Lancashire)",
  "en-gb-x-gbcwmd": "English (West Midlands)",
  "en-gb-x-rp": "English (Received Pronunciation)",
  "en-us-nyc": "English (New York City)",
  grc: "Ancient Greek",
  hak: "Hakka Chinese",
  hbs: "Serbo-Croatian",
  "hy-arevela": "Eastern Armenian",
  "hy-arevmda": "Western Armenian",
  hyw: "Western Armenian",
  io: "Ido",
  jbo: "Lojban",
  kaa: "Karakalpak",
  kl: "Greenlandic",
  lfn: "Lingua Franca Nova",
  ltg: "Latgalian",
  mto: "Totontepec Mixe",
  nci: "Classical Nahuatl",
  nog: "Nogai",
  pap: "Papiamento",
  piqd: "Klingon",
  py: "Pyash",
  qdb: "Lang Belta",
  quc: "K’iche’",
  qya: "Quenya",
  "ru-cl": "Russian (classic)",
  shn: "Shan",
  sjn: "Sindarin",
  smj: "Lule Sami",
  "vi-vn-x-central": "Vietnamese (central)",
  "vi-vn-x-south": "Vietnamese (southern)",
  xex: "Xextan",
  "zh-cmn": "Chinese",
  "zh-yue": "Cantonese",
};

/**
 * Returns the languages by name, each name once, and which of them to select: the one chosen last, else English, which
 * every voice of ours begins with, else the reader's own, else the first.
 *
 * @param recent the tags chosen lately, the newest first
 */
export function languageChoice(
  tags: readonly string[],
  recent: readonly string[],
  preferred: readonly string[],
): LanguageChoice {
  const options = new Map<string, LanguageOption>();
  // Of two tags with one name the shorter is the one without a reason to be longer.
  for (const tag of [...new Set(tags)].sort((a, b) => b.length - a.length || (a < b ? 1 : -1))) {
    const name = languageName(tag);
    options.set(name, { tag, name });
  }
  const all = [...options.values()].sort((a, b) => a.name.localeCompare(b.name));
  const known = (tag: string): LanguageOption | undefined => all.find((option) => option.tag === tag);
  const chosen = recent.flatMap((tag) => known(tag) ?? []).slice(0, RECENT);
  const wanted = [
    ...chosen.map(({ tag }) => tag),
    ...preferred.filter((tag) => tag.startsWith("en")),
    "en",
    "en-US",
    "en-GB",
    ...preferred,
  ];
  const selected = wanted.find(known) ?? all[0]?.tag ?? "";
  return { recent: chosen, others: all.filter((option) => !chosen.includes(option)), selected };
}

/** Returns the name of a language in English; the tag itself where it has none. */
export function languageName(tag: string): string {
  const known = NAMES[tag.toLowerCase()];
  if (known !== undefined) return known;
  try {
    return new Intl.DisplayNames(["en"], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}

/** Returns the tags that were chosen lately, the newest first. */
export function recallLanguages(store: Store): string[] {
  try {
    const found: unknown = JSON.parse(store.getItem(KEY) ?? "[]");
    return Array.isArray(found) ? found.filter((tag) => typeof tag === "string").slice(0, RECENT) : [];
  } catch {
    return [];
  }
}

/** Makes a tag the newest of those that were chosen. */
export function rememberLanguage(store: Store, tag: string): void {
  const others = recallLanguages(store).filter((each) => each !== tag);
  try {
    store.setItem(KEY, JSON.stringify([tag, ...others].slice(0, RECENT)));
  } catch {
    // Full, or forbidden: the next visit begins from the beginning.
  }
}
