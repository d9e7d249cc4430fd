import { expect, it } from "vitest";
import { AT_FIRST, PURPOSE_WORDS, consentWords, isOwn } from "../../../app/model/consent.ts";
import { Purpose } from "../../../sdk/index.ts";

it("has words for every purpose", () => {
  expect(Object.keys(PURPOSE_WORDS)).toEqual([...Purpose]);
  expect(Purpose.map((purpose) => consentWords([purpose]))).toEqual([
    "You may be heard and seen live.",
    "You may be recognised.",
    "You may be passed to a program that answers.",
    "You may be recorded.",
    "You may be sent to another machine.",
  ]);
});

it("says all that holds, and that nothing does", () => {
  expect(consentWords(AT_FIRST)).toBe("You may be heard and seen live and recognised.");
  expect(consentWords(["live", "recognition", "recording"])).toBe(
    "You may be heard and seen live, recognised and recorded.",
  );
  expect(consentWords([])).toBe("Nothing that you send is used.");
});

it("knows what is told of this page, and of another visitor", () => {
  expect(isOwn({ visitor_ref: "urn:me" }, "urn:me")).toBe(true);
  expect(isOwn({ visitor_ref: "urn:other" }, "urn:me")).toBe(false);
  expect([isOwn({}, "urn:me"), isOwn({ visitor_ref: "urn:other" }, "")]).toEqual([true, true]);
});
