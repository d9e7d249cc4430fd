/** The package as a user gets it: packed, installed in an empty folder, imported, compiled against, bundled. */

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const folder = mkdtempSync(`${tmpdir()}/openrois-package-`);

const run = (program: string, ...parameters: string[]): string =>
  execFileSync(program, parameters, { cwd: folder, encoding: "utf8", stdio: "pipe" });

/** Compiles modules strictly, as Node resolves them and as bundlers do. */
function compile(...names: string[]): void {
  const strict = ["--noEmit", "--strict", "--exactOptionalPropertyTypes", "--noUncheckedIndexedAccess"];
  const target = ["--target", "es2022", "--lib", "es2022,dom,dom.asynciterable"];
  for (const [module, resolution] of [
    ["nodenext", "nodenext"],
    ["esnext", "bundler"],
  ] as const) {
    const settings = ["--module", module, "--moduleResolution", resolution];
    run(`${ROOT}node_modules/.bin/tsc`, ...strict, ...target, ...settings, ...names);
  }
}

/** What a bundler makes of a module that uses the package. */
async function bundle(source: string): Promise<string> {
  const { outputFiles } = await build({
    stdin: { contents: source, resolveDir: folder },
    bundle: true,
    format: "esm",
    minify: true,
    write: false,
  });
  return outputFiles[0]?.text ?? "";
}

beforeAll(() => {
  execFileSync("node", ["build.mjs", "--package", `${folder}/built`], { cwd: ROOT, encoding: "utf8" });
  const packed = run("npm", "pack", "./built", "--silent").trim();
  writeFileSync(`${folder}/package.json`, '{ "private": true, "type": "module" }');
  run("npm", "install", "--offline", "--no-audit", "--no-fund", "--silent", `./${packed}`);
}, 60_000);

afterAll(() => {
  rmSync(folder, { recursive: true });
});

describe("the installed package", { timeout: 60_000 }, () => {
  it("has what is needed and nothing else", () => {
    const [{ files }] = JSON.parse(run("npm", "pack", "./built", "--dry-run", "--json")) as [
      { files: { path: string }[] },
    ];
    const names = files.map(({ path }) => path);
    const parts = ["LICENSE", "NOTICE", "README.md", "package.json"];
    expect(names).toEqual(expect.arrayContaining([...parts, "index.js", "index.d.ts", "media/index.d.ts"]));
    expect(names.filter((name) => !parts.includes(name) && !/\.(js|d\.ts)$/.test(name))).toEqual([]);
  });

  it("is imported in Node, the control plane without the media", () => {
    const program = `
      import * as sdk from "openrois";
      import { MediaReceiver } from "openrois/media";
      const client = new sdk.Client("http://robot:8765", { webSocket: () => { throw new Error(); } });
      const navigation = new sdk.Navigation(client, "robot/navigation");
      console.log(client.state.name, navigation.reachedTarget.eventType, typeof MediaReceiver, "MediaReceiver" in sdk);
    `;
    writeFileSync(`${folder}/user.js`, program);
    expect(run("node", "user.js").trim()).toBe("closed reached_target function false");
  });

  it("says what to do in an older Node without a WebSocket", () => {
    const program = `
      delete globalThis.WebSocket;
      const { Client } = await import("openrois");
      try { new Client("ws://robot"); } catch (error) { console.log(error.message); }
    `;
    writeFileSync(`${folder}/old.js`, program);
    expect(run("node", "old.js")).toMatch(/there is no WebSocket here: give the option webSocket/);
  });

  it("is compiled against, strictly", () => {
    writeFileSync(
      `${folder}/user.ts`,
      `
      import { Client, CommandFailed, Navigation, PersonDetection, RoISCommon, VideoStreaming, onlyComponent, where } from "openrois";
      import type { ComponentStatus, ReachedTarget, Result } from "openrois";
      import { MediaReceiver } from "openrois/media";

      declare module "openrois" {
        interface ExtensionMethods {
          "example.dance": { params: { readonly beats: number }; result: { readonly steps: number } };
        }
      }

      class Lamp extends RoISCommon<{ readonly brightness?: number }> {
        static readonly componentType = "urn:x-rois:def:component:Example::Lamp";
        protected override readonly parameterTypes = { brightness: "int" };
        readonly switched = this.event<{ readonly on: boolean }>("switched", { on: "bool" });
      }

      export async function use(): Promise<void> {
        const client = new Client("ws://127.0.0.1:8765/", { webSocket: (url, protocols) => new WebSocket(url, protocols) });
        await client.connect({ signal: AbortSignal.timeout(1000) });
        const { component_ref_list: refs } = await client.call("rois.command.search", { condition: "" });
        const first: string | undefined = refs?.[0];
        const results: readonly Result[] = await client.query("component_status", onlyComponent(first ?? ""));
        const navigation = await client.find(Navigation, where({ component_ref: "robot/navigation" }));
        await navigation.bound(async () => {
          await navigation.setParameter({ target_positions: ["lobby"], time_limit: 60_000 });
          await navigation.start();
        });
        const { status }: { status: ComponentStatus } = await navigation.componentStatus();
        for await (const reached of navigation.reachedTarget) {
          const target: ReachedTarget = reached;
          console.log(target.target, status, results);
        }
        const persons = new PersonDetection(client, "robot/persons");
        const heard = await persons.personDetected.subscribe(({ number, timestamp }) => {
          const at: number = timestamp.getTime() + number;
          console.log(at);
        });
        await heard.cancel();
        const lamp = await client.find(Lamp);
        await lamp.perform({ brightness: 80 }).catch((error: unknown) => {
          if (error instanceof CommandFailed) console.log(error.status);
        });
        client.on("lost", (claim) => console.log(claim.kind === "binding" ? claim.componentRef : claim.eventType, claim.error));
        new MediaReceiver(client).stream("avatar/video", "video");

        // @ts-expect-error a position is text
        await navigation.setParameter({ target_positions: [1] });
        // @ts-expect-error there is no such parameter
        await navigation.setParameter({ colour: "red" });
        const camera = await client.find(VideoStreaming);
        const { available_encodings: encodings = "" } = await camera.getParameter();
        // @ts-expect-error this one is only read
        await camera.setParameter({ available_encodings: encodings });
        // @ts-expect-error a method's params are known
        await client.call("rois.command.bind", { component: "robot/navigation" });
        // @ts-expect-error so is its result
        (await client.call("rois.command.search")).results;
        // @ts-expect-error there is no such method
        await client.call("rois.command.serach", { condition: "" });
        const { steps } = await client.call("example.dance", { beats: 3 });
        // @ts-expect-error an extension's params are what was declared
        await client.call("example.dance", { beats: "three" });
        console.log(steps + 1);
        // @ts-expect-error a lamp's event tells on
        await lamp.switched.subscribe(({ off }) => off);
        await client.close();
      }
    `,
    );
    compile("user.ts");
  });

  it("compiles all examples of its README", () => {
    const readme = readFileSync(new URL("../../sdk/README.md", import.meta.url), "utf8");
    const examples = [...readme.matchAll(/```ts\n(.*?)```/gs)].map(([, text = ""]) => text);
    expect(examples.length).toBeGreaterThan(4);
    const names = examples.map((text, index) => {
      writeFileSync(`${folder}/example${index}.ts`, text);
      return `example${index}.ts`;
    });
    compile(...names);
  });

  it("leaves out what is not used", async () => {
    const text = await bundle(
      'import { Client, Navigation } from "openrois"; globalThis.start = () => new Client().find(Navigation);',
    );
    const navigation = ["component:OMG::Navigation", "reached_target", "target_positions"];
    expect(navigation.filter((word) => !text.includes(word))).toEqual([]);
    const others = [
      "PersonDetection",
      "person_detected",
      "VideoStreaming",
      "encoding_parameters",
      "languages",
    ];
    const media = ["RTCPeerConnection", "getStats"];
    expect([...others, ...media].filter((word) => text.includes(word))).toEqual([]);
  });

  it("stays small", async () => {
    const sizes = {
      "Client and one component": 'export { Client, Navigation } from "openrois";',
      "all of the control plane": 'export * from "openrois";',
      "with the media": 'export * from "openrois"; export * from "openrois/media";',
    };
    const readme = readFileSync(new URL("../../sdk/README.md", import.meta.url), "utf8");
    const said = [...readme.matchAll(/([\d.]+) kB/g)].map(([, size]) => Number(size) * 1000);
    const zipped = await Promise.all(
      Object.values(sizes).map(
        async (source) => gzipSync(new TextEncoder().encode(await bundle(source))).length,
      ),
    );
    console.log(
      Object.keys(sizes)
        .map((name, index) => `${name}: ${zipped[index]} bytes gzipped`)
        .join("\n"),
    );
    expect(zipped[1]).toBeLessThanOrEqual(25_000);
    expect(zipped[0]).toBeLessThan(zipped[1] ?? 0);
    const [all, one, media] = said;
    expect(said).toHaveLength(3);
    for (const [index, promised] of [one, all, media].entries()) {
      expect(Math.abs((zipped[index] ?? 0) / (promised ?? 1) - 1)).toBeLessThan(0.05);
    }
  });
});
