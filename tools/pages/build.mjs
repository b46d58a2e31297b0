// Bundles the page: node build.mjs WEB_FOLDER NODE_MODULES OUTPUT. Script, style and the licences of what was bundled
// come into page.html at their places; the policy in its head names the script and the style by their hashes, so that
// nothing else runs, and forbids every connection.
import { createHash } from 'node:crypto';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

const [web, modules, output] = process.argv.slice(2);
const { build } = createRequire(path.join(modules, 'x.js'))('esbuild');

async function bundle(entry) {
  const result = await build({
    entryPoints: [path.join(web, entry)], bundle: true, minify: true, write: false, format: 'iife', charset: 'ascii',
    target: ['es2020', 'chrome100', 'firefox100', 'safari15'], nodePaths: [modules], legalComments: 'none',
    metafile: true, logLevel: 'warning',
  });
  return { text: result.outputFiles[0].text.trim(), inputs: Object.keys(result.metafile.inputs) };
}

function hash(text) {
  return `'sha256-${createHash('sha256').update(text, 'utf8').digest('base64')}'`;
}

// The page names the authors of the code that it contains, with their licences.
function collectLicences(inputs) {
  const names = new Set(inputs.map((file) => /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file)?.[1]).filter(Boolean));
  return [...names].sort().map((name) => {
    const folder = path.join(modules, name);
    const { version } = JSON.parse(readFileSync(path.join(folder, 'package.json'), 'utf8'));
    const file = ['LICENSE', 'LICENSE.md', 'LICENSE.txt'].map((f) => path.join(folder, f)).find(existsSync);
    return `${name} ${version}\n\n${readFileSync(file, 'utf8').trim()}\n`;
  }).join('\n\n');
}

const script = await bundle('main.js');
const style = await bundle('style.css');
// Inside of <script> and <style> only their own end tags end them.
if (/<\/script|<!--/i.test(script.text)) throw new Error('the script would end its own element');
if (/<\/style/i.test(style.text)) throw new Error('the style would end its own element');
const escape = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;');
const parts = {
  SCRIPT: script.text,
  STYLE: style.text,
  SCRIPT_HASH: hash(script.text),
  STYLE_HASH: hash(style.text),
  LICENCES: escape(collectLicences([...script.inputs, ...style.inputs])),
};
// The first line, "%HEAD title%", stands for the head that all pages share.
const head = readFileSync(new URL('web/head.html', import.meta.url), 'utf8').trim();
const source = readFileSync(path.join(web, 'page.html'), 'utf8');
if (!/^%HEAD .+%\n/.test(source)) throw new Error('the page does not begin with %HEAD title%');
const whole = source.replace(/^%HEAD (.+)%/, (_, title) => head.replace('%TITLE%', () => title));
const page = whole.replace(/%([A-Z_]+)%/g, (whole, name) => parts[name] ?? whole);
if (page.split('%UNLATCH_DATA%').length !== 2) throw new Error('the page needs one place for the data');
writeFileSync(output, page);
