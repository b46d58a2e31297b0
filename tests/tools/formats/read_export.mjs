// Contents of an exported file, read by another library, as JSON: node read_export.mjs NODE_MODULES FILE.mcap|FILE.parquet
// [NAME...]. `series` has all values of the topics or columns of these names.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, file, ...names] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(createRequire(path.join(modules, 'x.js')).resolve(name)).href);

async function readMcap(bytes) {
  const { McapIndexedReader, McapStreamReader } = await load('@mcap/core');
  const readable = { size: async () => BigInt(bytes.length), read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)) };
  // From the beginning, every checksum compared; then by the index.
  const { default: zstd } = await load('@foxglove/wasm-zstd');
  await zstd.isLoaded;
  const decompressHandlers = { zstd: (data, size) => zstd.decompress(data, Number(size)) };
  const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  stream.append(bytes);
  for (let record; (record = stream.nextRecord()) !== undefined;);
  if (!stream.done()) throw new Error('the file ends early');
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const channels = {}, counts = {}, last = {}, series = Object.fromEntries(names.map((name) => [name, []]));
  for (const channel of reader.channelsById.values()) channels[channel.topic] = reader.schemasById.get(channel.schemaId).name;
  for await (const message of reader.readMessages()) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
    last[topic] = JSON.parse(new TextDecoder().decode(message.data));
    series[topic]?.push(last[topic].values);
  }
  let metadata = {};
  for await (const record of reader.readMetadata({ name: 'unlatch' })) metadata = Object.fromEntries(record.metadata);
  const sizes = reader.chunkIndexes.map((index) => [index.compression, Number(index.compressedSize), Number(index.uncompressedSize)]);
  return { sizes, channels, counts, last, series, metadata, chunks: reader.chunkIndexes.length, indexed: reader.chunkIndexes.every((index) => index.messageIndexOffsets.size > 0) };
}

async function readParquet(bytes) {
  const { parquetMetadata, parquetReadObjects } = await load('hyparquet');
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const metadata = parquetMetadata(buffer);
  const rows = await parquetReadObjects({ file: buffer });
  const keys = Object.fromEntries(metadata.key_value_metadata.map((pair) => [pair.key, pair.value]));
  const units = JSON.parse(keys.units);
  const counts = Object.fromEntries(Object.keys(units).map((name) => [name, rows.filter((row) => row[name] != null).length]));
  const series = Object.fromEntries(names.map((name) => [name, rows.map((row) => row[name])]));
  return { rows: rows.length, last: rows.at(-1), keys, units, counts, series, events: rows.map((row) => row.events).filter((text) => text) };
}

const bytes = new Uint8Array(readFileSync(file));
const result = await (file.endsWith('.mcap') ? readMcap(bytes) : readParquet(bytes));
process.stdout.write(JSON.stringify(result, (_, value) => (typeof value === 'bigint' ? Number(value) : value)));
