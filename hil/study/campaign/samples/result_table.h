// Results of a campaign as a table: a row for each sample, in the order of their numbers, each once. The numbers stay
// in the file: rows are read one by one, columns a few together. Memory: 32 bytes a row, and one batch of columns.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hil/study/campaign/samples/result_file.h"

namespace unlatch::hil {

class ResultTable {
 public:
  static constexpr std::size_t kBatch = (16u << 20) / sizeof(double);
  // Reads every record once. `batch`: numbers read together, one column at least. Throws ResultError, as all that
  // reads.
  explicit ResultTable(ResultFile file, std::size_t batch = kBatch);

  [[nodiscard]] const ResultShape& shape() const { return file_.shape(); }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] std::int64_t get_sample(std::size_t row) const { return rows_[row].sample; }
  [[nodiscard]] SampleStatus get_status(std::size_t row) const { return rows_[row].status; }
  // First row whose sample is not before this one; size() if there is none.
  [[nodiscard]] std::size_t find(std::int64_t sample) const;
  // Hash of all samples; the same whatever ran them, in whatever order.
  [[nodiscard]] std::uint64_t hash() const { return hash_; }

  [[nodiscard]] SampleRecord read(std::size_t row) const { return file_.read(rows_[row].record); }
  // Numbers of a row, from this column on.
  void read_numbers(std::size_t row, std::size_t column, std::span<double> to) const {
    file_.read_numbers(rows_[row].record, column, to);
  }
  // A number of each of the first `count` rows; inputs are the first columns, then values. Columns one after the other
  // are fast. One thread at a time: the latest batch of columns is kept.
  [[nodiscard]] std::vector<double> read_column(std::size_t column, std::size_t count) const;

 private:
  struct Row {
    std::int64_t sample;
    std::uint32_t record;
    SampleStatus status;
  };
  struct Columns {
    std::size_t first = 0, count = 0;
    std::vector<double> numbers;  // column by column
  };
  void read_columns(std::size_t first) const;

  ResultFile file_;
  std::size_t batch_;
  std::vector<Row> rows_;
  std::uint64_t hash_ = 0;
  mutable Columns read_;
};

}  // namespace unlatch::hil
