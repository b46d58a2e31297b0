// Bundles the writers into one script: node build.mjs SOURCE_FOLDER NODE_MODULES OUTPUT. The licences of what is bundled
// stand at its end. WebAssembly is taken in as text: esbuild would import bytes by a property for each of them (1.5 s).
import { createRequire } from 'node:module';
import path from 'node:path';

const [source, modules, output] = process.argv.slice(2);
const { build } = createRequire(path.join(modules, 'x.js'))('esbuild');
await build({
  entryPoints: [path.join(source, 'main.mjs')], bundle: true, minify: true, outfile: output, format: 'cjs', platform: 'node',
  target: 'node18', charset: 'ascii', loader: { '.wasm': 'base64' }, nodePaths: [modules], legalComments: 'eof', logLevel: 'warning',
});
