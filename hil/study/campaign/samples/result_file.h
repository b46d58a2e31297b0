// Results of a campaign on disk: a header, and one record of fixed size for each sample, in the order of arrival.
// Records are only appended, each by one write with a checksum at its end, so a process may be killed at any instant:
// an incomplete record is cut off when the file is opened again.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/study/campaign/samples/sample_record.h"

namespace unlatch::hil {

// Error of a file that is not readable, belongs to another campaign, or is not writable (a full disk); what() names the
// file.
class ResultError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ResultFile {
 public:
  // Creates a file and replaces an existing one. Throws ResultError.
  static ResultFile create(const std::string& path, const ResultShape& shape);
  // Opens a file and cuts off an incomplete record; `writable`: for append().
  static ResultFile open(const std::string& path, bool writable);
  ~ResultFile();
  ResultFile(ResultFile&& other) noexcept;
  ResultFile& operator=(ResultFile&&) = delete;

  const ResultShape& shape() const { return shape_; }
  // Samples of the complete records, in the order of the file; those after a damaged record are included, the damaged
  // one is not.
  const std::vector<std::int64_t>& samples() const { return samples_; }
  [[nodiscard]] SampleRecord read(std::size_t record) const;
  // Reads numbers of a record, from number `first` on: inputs, then values.
  void read_numbers(std::size_t record, std::size_t first, std::span<double> to) const;
  // Appends a record. Throws ResultError; the file then ends with its last complete record.
  void append(const SampleRecord& record);

 private:
  ResultFile(int file, std::string path) : file_(file), path_(std::move(path)) {}
  void scan(bool writable);

  int file_ = -1;
  std::string path_;
  ResultShape shape_;
  std::vector<std::int64_t> samples_;
  std::vector<std::uint64_t> places_;  // bytes from the beginning of the file
  std::uint64_t end_ = 0;              // end of the last complete record
};

}  // namespace unlatch::hil
