/** The engines of a directory as a tree: with profiles where they are loaded, and with types alone elsewhere. Pure. */

import { codeOf } from "../../sdk/index.ts";
import type { ComponentEntry, EngineEntry, HRIComponentProfile, HRIEngineProfile } from "../../sdk/index.ts";
import { componentNode } from "./profile_tree.ts";
import type { ComponentNode, EngineNode } from "./profile_tree.ts";

/** The profiles that are loaded. */
export interface Loaded {
  component(version: string): HRIComponentProfile | undefined;
  engine(engineId: string): HRIEngineProfile | null;
}

export class EntryTree {
  /** Nodes by their entries, which stay the same objects while they say the same. */
  readonly #nodes = new WeakMap<ComponentEntry, ComponentNode>();

  /** Returns the engines at the top, those below each in the order of their ids. */
  build(entries: ReadonlyMap<string, EngineEntry>, loaded: Loaded): EngineNode[] {
    const below = new Map<string, EngineEntry[]>();
    for (const entry of [...entries.values()].sort((one, other) =>
      one.engine_id < other.engine_id ? -1 : 1,
    )) {
      // One whose parent is not listed would not be shown.
      const parentId = entries.has(entry.parent_id) ? entry.parent_id : "";
      const siblings = below.get(parentId);
      if (siblings) siblings.push(entry);
      else below.set(parentId, [entry]);
    }
    const node = (entry: EngineEntry): EngineNode => ({
      id: entry.engine_id,
      profile: loaded.engine(entry.engine_id),
      components: (entry.components ?? []).map((each) => this.#node(each, loaded)),
      engines: (below.get(entry.engine_id) ?? []).map(node),
    });
    return (below.get("") ?? []).map(node);
  }

  #node(entry: ComponentEntry, loaded: Loaded): ComponentNode {
    const profile = loaded.component(entry.profile_version);
    const known = this.#nodes.get(entry);
    if (known && (profile === undefined || known.profile === profile)) return known;
    const { component_ref: ref, component_type: code, function: kind = null } = entry;
    const node = componentNode(
      ref,
      profile ?? { identifier: { code }, name: codeOf(code), function: kind },
      profile !== undefined,
    );
    this.#nodes.set(entry, node);
    return node;
  }
}
