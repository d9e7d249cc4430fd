import { readFileSync, readdirSync } from "node:fs";
import { expect, it } from "vitest";

const APP = new URL("../../app/", import.meta.url);

/** What may stand on the page: string literals with spaces, and the text and spoken attributes of HTML. */
function sentences(file: string): string[] {
  const text = readFileSync(new URL(file, APP), "utf8");
  if (file.endsWith(".html"))
    return [...text.matchAll(/>([^<>]+)<|(?:aria-label|content|title|placeholder)="([^"]*)"/g)]
      .map(([, inner, attribute]) => (inner ?? attribute ?? "").trim())
      .filter((each) => each !== "");
  const code = text.replace(/\/\*[\s\S]*?\*\/|^\s*\/\/.*$/gm, "");
  return [...code.matchAll(/"(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`/g)]
    .map(([literal]) => literal.slice(1, -1))
    .filter((each) => / /.test(each));
}

it("calls a body, which may be a robot, no avatar", () => {
  const files = readdirSync(APP, { recursive: true }).filter((name) => /\.(ts|html)$/.test(name));
  const all = files.flatMap((name) => sentences(name).map((text) => `${name}: ${text}`));
  expect(all.length).toBeGreaterThan(200);
  // How to start one, and what the page is for, names both.
  const wrong = all.filter((each) => /\bavatar\b/i.test(each) && !/\brobot\b/.test(each));
  expect(wrong).toEqual([]);
});
