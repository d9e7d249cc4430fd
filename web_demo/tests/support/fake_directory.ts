/** The directory of a fake gateway: engines in pages, and which have changed. */

import type { EngineEntry, HRIComponentProfile } from "../../sdk/index.ts";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import type { FakeGateway } from "./fake_gateway.ts";

const URN = "urn:x-rois:def:component:OMG::";

export class FakeDirectory {
  readonly entries = new Map<string, EngineEntry>();
  readonly profiles = new Map<string, HRIComponentProfile>();
  /** Happens before the next replies of `list` and `read`, one for each. */
  readonly before: (() => void)[] = [];
  readonly #gateway: FakeGateway;
  #count = 0;

  /** @param room engines of a reply, and profiles */
  constructor(gateway: FakeGateway, room = 100) {
    this.#gateway = gateway;
    this.put("gateway", [], "");
    gateway
      .on("openrois.directory.list", ({ after = "" }) => {
        this.before.shift()?.();
        const behind = [...this.entries.keys()].filter((id) => id > String(after)).sort();
        const page = behind.slice(0, room);
        const next = behind.length > room ? page.at(-1) : "";
        return { engines: this.#told(page), next: next ?? "", count: this.entries.size };
      })
      .on("openrois.directory.read", ({ engine_ids }) => {
        this.before.shift()?.();
        const there = (engine_ids as string[]).filter((id) => this.entries.has(id));
        return { engines: this.#told(there.slice(0, room)), left: there.slice(room) };
      })
      .on("openrois.directory.profiles", ({ component_refs }) => {
        const refs = component_refs as string[];
        const told = refs.slice(0, room).flatMap((ref) => {
          const components = [...this.entries.values()].flatMap((entry) => entry.components ?? []);
          const version = components.find((each) => each.component_ref === ref)?.profile_version ?? "";
          const profile = this.profiles.get(version);
          return profile ? [[version, profile]] : [];
        });
        return { profiles: Object.fromEntries(told) as JsonObject, left: refs.slice(room) };
      });
  }

  /** Puts an engine with components of these types, without a notification. */
  put(engineId: string, types: readonly string[] = [], parentId = "gateway"): this {
    this.entries.set(engineId, {
      engine_id: engineId,
      parent_id: parentId,
      version: String(++this.#count),
      components: types.map((type) => ({
        component_ref: `${engineId}/${type.toLowerCase()}`,
        component_type: URN + type,
        function: type.endsWith("Detection") ? "sensing" : "actuation",
        profile_version: `v-${type}`,
      })),
    });
    for (const type of types)
      this.profiles.set(`v-${type}`, {
        identifier: { code: URN + type },
        name: type,
        query_profiles: [{ name: `is_${type}`, results: [] }],
      });
    return this;
  }

  remove(engineId: string): this {
    this.entries.delete(engineId);
    return this;
  }

  notify(changed: string[], gone: string[] = [], unnamed = 0): void {
    this.#gateway.notify("openrois.directory.changed", { changed, gone, unnamed });
  }

  #told(engineIds: readonly string[]): JsonObject[] {
    return engineIds.map((id) => this.entries.get(id) as unknown as JsonObject);
  }
}
