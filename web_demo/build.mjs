/**
 * Builds the page, and the SDK as a package in dist/openrois, ready for `npm pack`. With `--package FOLDER` it builds
 * the package alone, there; with `--preview` it serves the page with an avatar that lives in the browser itself.
 */

import { execFileSync } from "node:child_process";
import { copyFile, readFile, readdir, rm } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build, context } from "esbuild";

const root = path.dirname(fileURLToPath(import.meta.url));
const out = path.join(root, "openrois_web_demo", "static");
const PREVIEW_PORT = 8766;

/** The page loads the SDK as the file that others load, too: there is one copy of it. */
const sharedSdk = {
  name: "shared-sdk",
  setup({ onResolve }) {
    onResolve({ filter: /\/sdk\/(media\/)?index\.ts$/ }, () => ({ path: "./openrois.js", external: true }));
  },
};

/** The inspector is a file of its own, which the page loads when it is opened. */
const loadedLater = {
  name: "loaded-later",
  setup({ onResolve }) {
    onResolve({ filter: /\/inspector\.ts$/ }, ({ kind }) =>
      kind === "dynamic-import" ? { path: "./inspector.js", external: true } : undefined,
    );
  },
};

/** @param {string} main the module that is the page's script */
const options = (main) => ({
  absWorkingDir: root,
  entryPoints: [
    { in: main, out: "app" },
    { in: "app/styles/app.css", out: "app" },
    { in: "app/inspector/inspector.ts", out: "inspector" },
    { in: "app/styles/inspector.css", out: "inspector" },
    { in: "app/theme.ts", out: "theme" },
    { in: "sdk/browser.ts", out: "openrois" },
  ],
  plugins: [sharedSdk, loadedLater],
  bundle: true,
  format: "esm",
  target: ["chrome123", "firefox132", "safari17.5"],
  legalComments: "none",
  logLevel: "warning",
});

if (process.argv.includes("--preview")) await preview();
else if (process.argv.includes("--package")) await buildPackage(process.argv.at(-1));
else {
  await buildPage();
  await buildPackage(path.join(root, "dist", "openrois"));
}

/**
 * Builds the SDK as single modules, from which a bundler picks what a page uses, and their types.
 *
 * @param {string} folder is made anew
 */
async function buildPackage(folder) {
  await rm(folder, { recursive: true, force: true });
  const compiler = path.join(root, "node_modules", ".bin", "tsc");
  execFileSync(compiler, ["-p", "sdk", "--outDir", folder], { cwd: root, stdio: "inherit" });
  for (const file of ["sdk/package.json", "sdk/README.md", "../LICENSE", "../NOTICE"]) {
    await copyFile(path.join(root, file), path.join(folder, path.basename(file)));
  }
}

async function buildPage() {
  await rm(out, { recursive: true, force: true });
  await build({ ...options("app/main.ts"), minify: true, outdir: out });
  for (const name of ["index.html", "icon.svg"]) {
    await copyFile(path.join(root, "app", name), path.join(out, name));
  }
  await report();
}

async function report() {
  let total = 0;
  for (const name of (await readdir(out)).sort()) {
    const content = await readFile(path.join(out, name));
    const zipped = gzipSync(content).length;
    total += zipped;
    console.log(
      `${name.padEnd(12)} ${String(content.length).padStart(7)} bytes ${String(zipped).padStart(7)} gzip`,
    );
  }
  console.log(`together ${String(total).padStart(33)} gzip`);
}

async function preview() {
  const server = await context({ ...options("tests/preview/main.ts"), outdir: "app", write: false });
  const { port } = await server.serve({
    servedir: path.join(root, "app"),
    host: "127.0.0.1",
    port: PREVIEW_PORT,
  });
  console.log(`preview http://127.0.0.1:${port}/`);
}
