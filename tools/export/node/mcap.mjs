// The run as MCAP, with Foxglove's schemas, so that Foxglove shows the scene; messages as JSON, times from 0.
import { McapWriter } from '@mcap/core';
import { loadZstd } from './zstd.mjs';
import { FrameTransforms, Log, SceneUpdate } from '@foxglove/schemas/jsonschema';
import { closeSync, openSync, writeSync } from 'node:fs';

import { buildEntity, buildTransform } from './scene.mjs';

const INFO = 2;  // of foxglove.Log
const SMALL = 0.05;  // m, of a body without a shape
const number = { type: 'number' };

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
  for (const body of head.bodies) {
    const vector = listNumbers(['x', 'y', 'z']);
    await recording.addChannel(`/bodies/${body.name}`, 'unlatch.BodyVelocity',
      { type: 'object', properties: { v: vector, w: vector } }, [['units', 'v: m/s in W; w: rad/s in body axes']]);
  }
  for (const joint of head.joints) {
    const schema = listNumbers(head.rows);
    schema.properties.mode = { type: 'string' };
    await recording.addChannel(`/joints/${joint}`, 'unlatch.Reaction', schema, [['units', 'N, N m, on the follower']]);
  }
  if (head.channels.length > 0) await recording.addChannel('/channels', 'unlatch.Channels', listNumbers(head.channels.map((c) => c.name)));
  if (head.clearance.length > 0) {
    await recording.addChannel('/clearance', 'unlatch.Clearance', listNumbers(head.clearance.map(nameOf)), [['units', 'm']]);
  }
}

const nameOf = (pair) => pair.join('-');

async function addTick(recording, head, tick) {
  const time = toTime(tick.t);
  const timestamp = toStamp(time);
  const names = Object.keys(tick.bodies);
  await recording.add('/tf', time, { transforms: names.map((name) => buildTransform(name, tick.bodies[name], timestamp)) });
  for (const name of names) {
    const toObject = ([x, y, z]) => ({ x, y, z });
    await recording.add(`/bodies/${name}`, time, { v: toObject(tick.bodies[name].v), w: toObject(tick.bodies[name].w) });
  }
  for (const [name, reaction] of Object.entries(tick.reactions)) {
    const values = Object.fromEntries(head.rows.map((row) => [row, 0]));
    reaction.rows.forEach((row, i) => { values[row] = reaction.lambda[i]; });
    await recording.add(`/joints/${name}`, time, { ...values, mode: reaction.mode });
  }
  if (head.channels.length > 0) await recording.add('/channels', time, tick.channels);
  if (head.clearance.length > 0) {
    await recording.add('/clearance', time, Object.fromEntries(tick.clearance.map((value, i) => [nameOf(head.clearance[i]), value])));
  }
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
        deletions: [], entities: head.bodies.map((body, i) => buildEntity(body, i, SMALL)) });
    } else if (line.kind === 'tick') {
      await addTick(recording, head, line);
    } else if (line.kind === 'event') {
      const time = toTime(line.t);
      await recording.add('/events', time, {
        timestamp: toStamp(time), level: INFO, message: `${line.name} ${line.subject}`.trim(), name: 'unlatch', file: '', line: 0 });
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
