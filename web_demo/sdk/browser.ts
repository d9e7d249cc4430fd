/** The whole SDK as one module, for a page without a build step. */

export * from "./index.ts";
export * from "./media/index.ts";
