// node - FORMAT FILE: writes what comes on descriptor 3. The program on standard input is this one, bundled.
import { readLines } from './lines.mjs';
import { writeMcap } from './mcap.mjs';
import { writeParquet } from './parquet.mjs';

const [format, path] = process.argv.slice(2);
(format === 'mcap' ? writeMcap : writeParquet)(readLines(), path).catch((error) => {
  process.stderr.write(`${path}: ${error.message}\n`);
  process.exitCode = 1;
});
