/** The few functions of Node that the tests use; its whole type package would make Node's globals look like ours. */
declare module "node:fs" {
  export function existsSync(path: URL): boolean;
  export function mkdtempSync(prefix: string): string;
  export function readFileSync(path: URL, encoding: "utf8"): string;
  export function readdirSync(path: URL, options?: { recursive: boolean }): string[];
  export function rmSync(path: string, options: { recursive: boolean }): void;
  export function writeFileSync(path: string, text: string): void;
}
declare module "node:os" {
  export function tmpdir(): string;
}
declare module "node:url" {
  export function fileURLToPath(url: URL): string;
}
declare module "node:zlib" {
  export function gzipSync(content: Uint8Array): Uint8Array;
}
declare module "node:child_process" {
  export function execFileSync(
    program: string,
    parameters: readonly string[],
    options: { cwd: string; encoding: "utf8"; stdio?: "pipe" },
  ): string;
}
