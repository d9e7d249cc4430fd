import { describe, expect, it } from "vitest";
import { MAX_PEERS, MAX_WAITING_CANDIDATES, Negotiation } from "../../sdk/media/negotiation.ts";
import type { Candidate, Effect } from "../../sdk/media/negotiation.ts";
import type { Offer } from "../../sdk/rois/generated/types.ts";

const offer = (peer_id: string, generation: number, replaces?: string): Offer => ({
  peer_id,
  generation,
  sdp: `offer ${generation}`,
  streams: [],
  ...(replaces !== undefined && { replaces }),
});

const candidate = (name: string | null): Candidate => ({
  candidate: name,
  sdp_mid: "0",
  sdp_m_line_index: 0,
});
const kinds = (effects: Effect[]): string[] => effects.map((effect) => effect.kind);

/** A negotiation in which the first offer of peer "p" is answered. */
function answered(): Negotiation {
  const negotiation = new Negotiation();
  negotiation.offer(offer("p", 1));
  negotiation.answered("p", 1, "answer 1");
  return negotiation;
}

describe("offers", () => {
  it("open a peer once, and are answered", () => {
    const negotiation = new Negotiation();
    expect(negotiation.offer(offer("p", 1))).toEqual([
      { kind: "open", peerId: "p", replaces: null },
      { kind: "apply", offer: offer("p", 1) },
    ]);
    expect(negotiation.answered("p", 1, "answer")).toEqual([
      { kind: "send_answer", peerId: "p", generation: 1, sdp: "answer" },
    ]);
    expect(kinds(negotiation.offer(offer("p", 2)))).toEqual(["apply"]);
  });

  it.each([
    ["repeated", 1],
    ["older", 0],
  ])("that are %s are dropped", (_, generation) => {
    expect(answered().offer(offer("p", generation))).toEqual([]);
  });

  it("are applied one at a time, and of those that wait the newest", () => {
    const negotiation = new Negotiation();
    negotiation.offer(offer("p", 1));
    expect(negotiation.offer(offer("p", 2))).toEqual([]);
    expect(negotiation.offer(offer("p", 3))).toEqual([]);
    expect(negotiation.answered("p", 1, "a")).toEqual([
      { kind: "send_answer", peerId: "p", generation: 1, sdp: "a" },
      { kind: "apply", offer: offer("p", 3) },
    ]);
    expect(kinds(negotiation.answered("p", 3, "a"))).toEqual(["send_answer"]);
  });

  it("that replace a peer open another beside it", () => {
    const negotiation = answered();
    expect(negotiation.offer(offer("q", 1, "p"))[0]).toEqual({ kind: "open", peerId: "q", replaces: "p" });
    expect(kinds(negotiation.offer(offer("p", 2)))).toEqual(["apply"]);
  });

  it("open a bounded number of peers", () => {
    const negotiation = new Negotiation();
    for (let index = 0; index < MAX_PEERS; index++) {
      expect(negotiation.offer(offer(`p${index}`, 1))).not.toEqual([]);
    }
    expect(negotiation.offer(offer("one too many", 1))).toEqual([]);
    negotiation.endPeer("p0", "done");
    expect(negotiation.offer(offer("one in its place", 1))).not.toEqual([]);
  });
});

describe("answers", () => {
  it.each([
    ["of an unknown peer", "x", 1],
    ["of another generation", "p", 2],
  ])("%s go nowhere", (_, peerId, generation) => {
    const negotiation = new Negotiation();
    negotiation.offer(offer("p", 1));
    expect(negotiation.answered(peerId, generation, "a")).toEqual([]);
  });

  it("are given once", () => {
    expect(answered().answered("p", 1, "again")).toEqual([]);
  });
});

describe("candidates of the engine", () => {
  it("wait for the description, then follow the answer in order", () => {
    const negotiation = new Negotiation();
    negotiation.offer(offer("p", 1));
    for (const name of ["a", "b"]) {
      expect(negotiation.candidate({ peer_id: "p", generation: 1, ...candidate(name) })).toEqual([]);
    }
    expect(negotiation.answered("p", 1, "x").slice(1)).toEqual([
      { kind: "add_candidate", peerId: "p", candidate: candidate("a") },
      { kind: "add_candidate", peerId: "p", candidate: candidate("b") },
    ]);
  });

  it.each([
    ["the current generation", 2, ["add_candidate"]],
    ["an earlier one, which shares the ICE session", 1, ["add_candidate"]],
    ["one that has not been offered", 3, []],
  ])("of %s", (_, generation, expected) => {
    const negotiation = answered();
    negotiation.offer(offer("p", 2));
    negotiation.answered("p", 2, "a");
    expect(kinds(negotiation.candidate({ peer_id: "p", generation, ...candidate("c") }))).toEqual(expected);
  });

  it("of an unknown peer are dropped", () => {
    expect(answered().candidate({ peer_id: "x", generation: 1, ...candidate("c") })).toEqual([]);
  });
});

describe("candidates of our own", () => {
  it("never go before the answer to which they belong", () => {
    const negotiation = new Negotiation();
    negotiation.offer(offer("p", 1));
    expect(negotiation.gathered("p", candidate("a"))).toEqual([]);
    expect(negotiation.answered("p", 1, "x").slice(1)).toEqual([
      { kind: "send_candidate", message: { peer_id: "p", generation: 1, ...candidate("a") } },
    ]);
    expect(negotiation.gathered("p", candidate(null))).toEqual([
      { kind: "send_candidate", message: { peer_id: "p", generation: 1, ...candidate(null) } },
    ]);
    expect(negotiation.gathered("x", candidate("a"))).toEqual([]);
  });
});

it("keeps a bounded number of candidates", () => {
  const negotiation = new Negotiation();
  negotiation.offer(offer("p", 1));
  for (let index = 0; index < 2 * MAX_WAITING_CANDIDATES; index++) {
    negotiation.gathered("p", candidate("mine"));
    negotiation.candidate({ peer_id: "p", generation: 1, ...candidate("theirs") });
  }
  expect(negotiation.answered("p", 1, "x")).toHaveLength(1 + 2 * MAX_WAITING_CANDIDATES);
});

describe("the end of a peer", () => {
  it("closes it once, for good", () => {
    const negotiation = answered();
    expect(negotiation.endPeer("p", "bye")).toEqual([{ kind: "close", peerId: "p", reason: "bye" }]);
    expect(negotiation.endPeer("p", "bye")).toEqual([]);
    expect(negotiation.offer(offer("p", 2))).toEqual([]);
    expect(negotiation.gathered("p", candidate("a"))).toEqual([]);
  });

  it("while an answer is being made leaves that answer unsent", () => {
    const negotiation = new Negotiation();
    negotiation.offer(offer("p", 1));
    negotiation.endPeer("p", "bye");
    expect(negotiation.answered("p", 1, "late")).toEqual([]);
  });

  it("may come before its first offer", () => {
    const negotiation = new Negotiation();
    expect(negotiation.endPeer("p", "bye")).toEqual([]);
    expect(negotiation.offer(offer("p", 1))).toEqual([]);
  });

  it("is remembered in a bounded number", () => {
    const negotiation = new Negotiation();
    for (let index = 0; index <= 64; index++) negotiation.endPeer(`p${index}`, "bye");
    expect(negotiation.offer(offer("p64", 1))).toEqual([]);
    expect(negotiation.offer(offer("p0", 1))).not.toEqual([]);
  });

  it("comes for all with the session, without closing what still plays", () => {
    const negotiation = answered();
    negotiation.abandon();
    expect(negotiation.gathered("p", candidate("a"))).toEqual([]);
    expect(negotiation.offer(offer("p", 2))).toEqual([]);
    expect(kinds(negotiation.offer(offer("q", 1)))).toEqual(["open", "apply"]);
  });
});
