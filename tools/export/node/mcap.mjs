// The run as MCAP, with Foxglove's schemas, so that Foxglove shows the scene; messages as JSON, times from 0.
import { McapWriter } from '@mcap/core';
import { loadZstd } from './zstd.mjs';
import { FrameTransforms, Log, SceneUpdate } from '@foxglove/schemas/jsonschema';
import { closeSync, openSync, writeSync } from 'node:fs';

import { buildEntity, buildGround, buildTransform } from './scene.mjs';

const INFO = 2;  // of foxglove.Log
const SMALL = 0.05;  // m, of a body without a shape
const number = { type: 'number' };
const TOUCH = { type: 'object', properties: { contact: { type: 'string' }, shapes: { type: 'array', items: { type: 'string' } },
  ...Object.fromEntries(['t', 'lift', 'duration', 'peak_force', 'peak_t', 'depth', 'impulse'].map((name) => [name, number])) } };

class File {
  #file;
  #position = 0n;
  constructor(path) { this.#file = openSync(path, 'w'); }
  position() { return this.#position; }
  async write(bytes) {
    for (let done = 0; done < bytes.length;) done += writeSync(this.#file, bytes, done, bytes.length - done);
    this.#position += BigInt(bytes.length);
  }
  close() { closeSync(this.#file); }
}

class Recording {
  #writer;
  #channels = new Map();
  #encoder = new TextEncoder();
  constructor(writer) { this.#writer = writer; }

  async addChannel(topic, name, schema, metadata = []) {
    const schemaId = await this.#writer.registerSchema(
      { name, encoding: 'jsonschema', data: this.#encoder.encode(JSON.stringify(schema)) });
    const id = await this.#writer.registerChannel(
      { topic, schemaId, messageEncoding: 'json', metadata: new Map(metadata) });
    this.#channels.set(topic, { id, sequence: 0 });
  }

  has(topic) { return this.#channels.has(topic); }

  async add(topic, time, message) {
    const channel = this.#channels.get(topic);
    await this.#writer.addMessage({
      channelId: channel.id, sequence: channel.sequence++, logTime: time, publishTime: time,
      data: this.#encoder.encode(JSON.stringify(message)),
    });
  }
}

const toTime = (seconds) => BigInt(Math.round(seconds * 1e9));
const toStamp = (time) => ({ sec: Number(time / 1000000000n), nsec: Number(time % 1000000000n) });
const listNumbers = (names) => ({ type: 'object', properties: Object.fromEntries(names.map((name) => [name, number])) });

async function addChannels(recording, head) {
  await recording.addChannel('/scene', 'foxglove.SceneUpdate', SceneUpdate);
  await recording.addChannel('/tf', 'foxglove.FrameTransforms', FrameTransforms);
  await recording.addChannel('/events', 'foxglove.Log', Log);
  for (const [topic, outputs] of groupOutputs(head)) {
    const units = outputs.map((output) => [output.what, [output.columns[0].unit, output.frame].filter(Boolean).join(', ')]);
    const numbers = ['/elements', '/signals', '/quantities'].some((folder) => topic.startsWith(folder)) ? number : { type: 'array', items: number };
    const properties = Object.fromEntries(outputs.map((output) => [keyOf(output), isVector(output) ? listNumbers(['x', 'y', 'z']) : numbers]));
    if (topic.startsWith('/joints')) Object.assign(properties, listNumbers(head.rows).properties, { mode: { type: 'string' } });
    await recording.addChannel(topic, SCHEMAS[topic.split('/')[1]], { type: 'object', properties }, units);
  }
  if (head.channels.length > 0) await recording.addChannel('/channels', 'unlatch.Channels', listNumbers(head.channels.map((c) => c.name)));
  if (head.clearance.length > 0) {
    await recording.addChannel('/clearance', 'unlatch.Clearance', listNumbers(head.clearance.map(nameOf)), [['units', 'm']]);
  }
}

const nameOf = (pair) => pair.join('-');

// Outputs of the topics that hold one subject each: [topic, [{what, frame, columns}]]
function groupOutputs(head) {
  const topics = new Map();
  for (const output of head.outputs) {
    const [group, of, what] = output.name.split('.');
    const topic = { body: `/bodies/${of}`, joint: `/joints/${of}`, element: `/elements/${of}`, sensor: `/sensors/${of}`, received: `/received/${of}`, signal: '/signals', quantity: '/quantities' }[group];
    if (topic === undefined) continue;
    if (!topics.has(topic)) topics.set(topic, []);
    topics.get(topic).push({ ...output, group, of, what: what ?? (isSensor(group) ? 'values' : of) });
  }
  return topics;
}

const SCHEMAS = {
  bodies: 'unlatch.Body', joints: 'unlatch.Joint', elements: 'unlatch.Element', sensors: 'unlatch.Sensor', received: 'unlatch.Sensor', signals: 'unlatch.Signals',
  quantities: 'unlatch.Quantities',
};
const KEYS = { position: 'p', attitude: 'q', velocity: 'v', rate: 'w', acceleration: 'a', angular_acceleration: 'alpha' };
const keyOf = (output) => (output.group === 'body' ? KEYS[output.what] ?? output.what : output.what);
const isSensor = (group) => group === 'sensor' || group === 'received';
const isVector = (output) => output.columns.length === 3 && !isSensor(output.group);
const toObject = (value) => (value.length === 3 ? { x: value[0], y: value[1], z: value[2] } : value);
const mapValues = (object) => Object.fromEntries(Object.entries(object).map(([key, value]) => [key, Array.isArray(value) ? toObject(value) : value]));

// Topics of one subject have what is due at this tick.
async function addTick(recording, head, tick) {
  const time = toTime(tick.t);
  const timestamp = toStamp(time);
  const placed = Object.keys(tick.bodies).filter((name) => tick.bodies[name].p && tick.bodies[name].q);
  if (placed.length > 0) {
    await recording.add('/tf', time, { transforms: placed.map((name) => buildTransform(name, tick.bodies[name], timestamp)) });
  }
  for (const [name, body] of Object.entries(tick.bodies)) await recording.add(`/bodies/${name}`, time, mapValues(body));
  for (const name of new Set([...Object.keys(tick.reactions), ...Object.keys(tick.joints)])) {
    const reaction = tick.reactions[name];
    const values = reaction === undefined ? {} : { ...Object.fromEntries(head.rows.map((row) => [row, 0])), mode: reaction.mode };
    reaction?.rows.forEach((row, i) => { values[row] = reaction.lambda[i]; });
    await recording.add(`/joints/${name}`, time, { ...values, ...mapValues(tick.joints[name] ?? {}) });
  }
  for (const [name, element] of Object.entries(tick.elements)) await recording.add(`/elements/${name}`, time, element);
  for (const [name, values] of Object.entries(tick.sensors)) await recording.add(`/sensors/${name}`, time, { values });
  for (const [name, values] of Object.entries(tick.received ?? {})) await recording.add(`/received/${name}`, time, { values });
  if (Object.keys(tick.quantities ?? {}).length > 0) await recording.add('/quantities', time, tick.quantities);
  if (Object.keys(tick.signals).length > 0) await recording.add('/signals', time, tick.signals);
  if (Object.keys(tick.channels).length > 0) await recording.add('/channels', time, tick.channels);
  const clearance = Object.fromEntries(tick.clearance.map((value, i) => [nameOf(head.clearance[i]), value]).filter(([, value]) => value !== null));
  if (Object.keys(clearance).length > 0) await recording.add('/clearance', time, clearance);
}

export async function writeMcap(lines, path) {
  const file = new File(path);
  const compress = await loadZstd();
  const writer = new McapWriter({ writable: file, compressChunk: (bytes) => ({ compression: 'zstd', compressedData: compress(bytes) }) });
  await writer.start({ profile: '', library: 'unlatch' });
  const recording = new Recording(writer);
  let head;
  for await (const line of lines) {
    if (line.kind === 'run') {
      head = line;
      await addChannels(recording, head);
      await recording.add('/scene', toTime(head.first_t), {
        deletions: [], entities: [...head.bodies.map((body, i) => buildEntity(body, i, SMALL)), ...buildGround(head.ground)] });
    } else if (line.kind === 'tick') {
      await addTick(recording, head, line);
    } else if (line.kind === 'touch') {
      if (!recording.has('/touches')) await recording.addChannel('/touches', 'unlatch.Touch', TOUCH, [['units', 's, N, m, N s']]);
      const { kind, ...touch } = line;
      await recording.add('/touches', toTime(line.t), touch);
    } else if (line.kind === 'event') {
      const time = toTime(line.t);
      await recording.add('/events', time, {
        timestamp: toStamp(time), level: INFO, message: `${line.name} ${line.subject}${line.shapes ? ` (${line.shapes})` : ''}`.trim(), name: 'unlatch', file: '', line: 0 });
    } else if (line.kind === 'end') {
      const text = ['scenario', 'program', 'compiler', 'model_hash'].map((key) => [key, String(head[key])]);
      await writer.addMetadata({ name: 'unlatch', metadata: new Map([...text, ['status', line.status], ['hash', line.hash]]) });
      await writer.addAttachment({
        name: 'scenario.yaml', mediaType: 'application/yaml', logTime: 0n, createTime: 0n,
        data: new TextEncoder().encode(head.scenario_text) });
    }
  }
  await writer.end();
  file.close();
}
