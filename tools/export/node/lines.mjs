// Input from the program: one JSON object on each line, on descriptor 3, read as it arrives.
import { createReadStream } from 'node:fs';
import { createInterface } from 'node:readline';

export async function* readLines() {
  const lines = createInterface({ input: createReadStream('', { fd: 3, highWaterMark: 1 << 20 }), crlfDelay: Infinity });
  for await (const line of lines) yield JSON.parse(line);
}
