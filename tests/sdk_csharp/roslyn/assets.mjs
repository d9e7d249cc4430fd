// What a bundler would do: the module of an asset is its address.
const ASSET = /\.(?:dll|dat|wasm)$/;

export const load = (url, context, next) =>
  ASSET.test(url)
    ? { format: "module", source: `export default ${JSON.stringify(url)};`, shortCircuit: true }
    : next(url, context);
