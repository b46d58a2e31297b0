// The table of a run as Parquet, a row group at a time.
import { ParquetWriter } from 'hyparquet-writer';
import { fileWriter } from 'hyparquet-writer/src/node.js';

const GROUP = 4096;  // rows

const TYPES = {
  integer: { type: 'INT64' },
  number: { type: 'DOUBLE' },
  optional: { type: 'DOUBLE', repetition_type: 'OPTIONAL' },  // null: there is no value
  text: { type: 'BYTE_ARRAY', converted_type: 'UTF8' },
};

export async function writeParquet(lines, path) {
  let writer, columns, metadata, rows = [];
  const flush = async () => {
    const columnData = columns.map((column, k) => ({
      name: column.name, data: rows.map((row) => (column.type === 'integer' ? BigInt(row[k]) : row[k])) }));
    rows = [];
    await writer.write({ columnData, rowGroupSize: GROUP });
  };
  for await (const line of lines) {
    if (columns === undefined) {
      columns = line.columns;
      const schema = [{ name: 'run', num_children: columns.length },
        ...columns.map((column) => ({ name: column.name, repetition_type: column.optional ? 'OPTIONAL' : 'REQUIRED', ...TYPES[column.type] }))];
      const units = Object.fromEntries(columns.map((column) => [column.name, column.unit]));
      metadata = [{ key: 'units', value: JSON.stringify(units) }, { key: 'scenario', value: line.scenario }];
      writer = new ParquetWriter({ writer: fileWriter(path), schema, createdBy: 'unlatch', kvMetadata: metadata });
    } else if (!Array.isArray(line)) {  // how the run ended
      for (const [key, value] of Object.entries(line)) metadata.push({ key, value });
    } else {
      rows.push(line);
      if (rows.length === GROUP) await flush();
    }
  }
  if (rows.length > 0) await flush();
  await writer.finish();
}
