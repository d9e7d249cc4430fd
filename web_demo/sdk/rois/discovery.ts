/** Finding in a profile what an engine can do. */

import type { Profile } from "./client.ts";
import type { HRIComponentProfile } from "./generated/types.ts";

/** Returns the code of a component's type without authority: `VideoStreaming`. */
export function componentType(profile: HRIComponentProfile): string {
  return codeOf(profile.identifier.code);
}

/** Returns the code in the URN of a component's type: `VideoStreaming`. */
export function codeOf(urn: string): string {
  return urn.split(":").at(-1) ?? "";
}

/** Returns the URN of a component's type, formed of authority and code unless the code is a URN itself. */
export function componentUrn(profile: HRIComponentProfile): string {
  const { authority = "", code } = profile.identifier;
  return code.startsWith("urn:") ? code : `urn:x-rois:def:component:${authority}::${code}`;
}

/** Returns the id of the engine that a component reference leads to. */
export function engineOf(componentRef: string): string {
  return componentRef.split("/")[0] ?? "";
}

/** Returns, for each engine that has components, the first component of each type. */
export function componentsByEngine(profile: Profile): Map<string, Map<string, string>> {
  const engines = new Map<string, Map<string, string>>();
  for (const [componentRef, component] of Object.entries(profile.component_profiles)) {
    const components = engines.get(engineOf(componentRef)) ?? new Map<string, string>();
    engines.set(engineOf(componentRef), components);
    const type = componentType(component);
    if (!components.has(type)) components.set(type, componentRef);
  }
  return engines;
}
