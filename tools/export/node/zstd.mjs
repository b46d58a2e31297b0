// Zstandard for the chunks of an MCAP file: Node.js has it from 22 on, and Debian 12 has 18.
/*! @foxglove/wasm-zstd: MIT, Copyright (c) 2023 Foxglove. Zstandard: BSD, Copyright (c) Meta Platforms, Inc. and affiliates. */
import factory from '@foxglove/wasm-zstd/dist/wasm-zstd.js';
import wasm from '@foxglove/wasm-zstd/dist/wasm-zstd.wasm';

const LEVEL = 3;  // Zstandard's own default

// A function from bytes to compressed bytes.
export async function loadZstd() {
  const zstd = await factory({ wasmBinary: Buffer.from(wasm, 'base64') });
  return (bytes) => {
    const room = zstd._compressBound(bytes.length);
    const from = zstd._malloc(bytes.length), to = zstd._malloc(room);
    try {
      new Uint8Array(zstd.HEAPU8.buffer, from, bytes.length).set(bytes);
      const size = zstd._compress(to, room, from, bytes.length, LEVEL);
      if (size < 0) throw new Error('a chunk cannot be compressed');
      return new Uint8Array(zstd.HEAPU8.buffer, to, size).slice();
    } finally {
      zstd._free(from);
      zstd._free(to);
    }
  };
}
