/** Which letters of a text a voice of some language may spell out instead of reading them. Pure. */

/** ISO 15924 codes of the scripts that are looked for, and what their letters are called. */
const NAMES: Readonly<Record<string, string>> = {
  Arab: "Arabic letters",
  Armn: "Armenian letters",
  Beng: "Bengali letters",
  Cyrl: "Cyrillic letters",
  Deva: "Devanagari letters",
  Ethi: "Ethiopic letters",
  Geor: "Georgian letters",
  Grek: "Greek letters",
  Hang: "Korean letters",
  Hani: "Chinese characters",
  Hebr: "Hebrew letters",
  Hira: "Japanese letters",
  Kana: "Japanese letters",
  Taml: "Tamil letters",
  Thai: "Thai letters",
};
/** The scripts of languages that are written in several. */
const SEVERAL: Readonly<Record<string, readonly string[]>> = {
  Hans: ["Hani"],
  Hant: ["Hani"],
  // Offline voices of Japanese read kana; how kanji are read depends on what they mean.
  Jpan: ["Hira", "Kana"],
  Kore: ["Hang"],
};
const SHOWN = 8;

/**
 * Returns a hint for a visitor who is about to have a text spoken; empty where the voice can be expected to read it.
 *
 * @param tag the voice's language, as BCP 47 tag
 * @param language the name of that language
 */
export function spellingHint(text: string, tag: string, language: string): string {
  const own = scriptsOf(tag);
  if (own === null) return "";
  for (const [script, name] of Object.entries(NAMES)) {
    if (own.includes(script)) continue;
    const found = text.match(new RegExp(`\\p{Script=${script}}+`, "u"))?.[0];
    if (found === undefined) continue;
    const letters = [...found];
    const shown = letters.length > SHOWN ? `${letters.slice(0, SHOWN).join("")}…` : found;
    if (tag.startsWith("ja")) return `“${shown}” may be spelled out: write it in hiragana or katakana.`;
    return `“${shown}” may be spelled out: these are ${name}, and the voice speaks ${language}. Choose another language.`;
  }
  return "";
}

/** The scripts that a language is written in; null for a tag that says nothing of it. */
function scriptsOf(tag: string): readonly string[] | null {
  try {
    const { script } = new Intl.Locale(tag).maximize();
    return script === undefined ? null : (SEVERAL[script] ?? [script]);
  } catch {
    return null;
  }
}
