/** The two functions of Node that the tests use; its whole type package would make Node's globals look like ours. */
declare module "node:fs" {
  export function existsSync(path: URL): boolean;
  export function readFileSync(path: URL, encoding: "utf8"): string;
}
