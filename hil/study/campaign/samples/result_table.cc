#include "hil/study/campaign/samples/result_table.h"

#include <algorithm>
#include <utility>

namespace unlatch::hil {

ResultTable::ResultTable(ResultFile file, std::size_t batch) : file_(std::move(file)), batch_(batch) {
  rows_.resize(file_.samples().size());
  for (std::size_t i = 0; i < rows_.size(); ++i)
    rows_[i] = {file_.samples()[i], static_cast<std::uint32_t>(i), SampleStatus::kDone};
  const auto place = [](const Row& row) { return std::pair(row.sample, row.record); };
  std::ranges::sort(rows_, {}, place);
  const auto is_same = [](const Row& a, const Row& b) { return a.sample == b.sample; };
  rows_.erase(std::unique(rows_.begin(), rows_.end(), is_same), rows_.end());
  for (Row& row : rows_) {
    const SampleRecord record = file_.read(row.record);
    row.status = record.result.status;
    hash_ = add_to_hash(hash_, calc_hash(record));
  }
}

std::size_t ResultTable::find(std::int64_t sample) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(rows_, sample, {}, &Row::sample) - rows_.begin());
}

std::vector<double> ResultTable::read_column(std::size_t column, std::size_t count) const {
  if (column < read_.first || column >= read_.first + read_.count) read_columns(column);
  const auto begin = read_.numbers.begin() + static_cast<std::ptrdiff_t>((column - read_.first) * rows_.size());
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

// Replaces the columns that are kept by those from this one on.
void ResultTable::read_columns(std::size_t first) const {
  const std::size_t rows = rows_.size(), all = std::size_t{shape().inputs} + shape().values;
  const std::size_t count = std::min(all - first, std::max<std::size_t>(1, batch_ / std::max<std::size_t>(1, rows)));
  read_.first = first;
  read_.count = count;
  read_.numbers.resize(count * rows);
  std::vector<double> numbers(count);
  for (std::size_t row = 0; row < rows; ++row) {
    file_.read_numbers(rows_[row].record, first, numbers);
    for (std::size_t k = 0; k < count; ++k) read_.numbers[k * rows + row] = numbers[k];
  }
}

}  // namespace unlatch::hil
