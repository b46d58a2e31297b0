// The results of a campaign on disk: a header, and one record of fixed size for each sample, in the order in which they
// came. Records are only added, each by one write with a checksum at its end, so that a process may be killed at any
// instant: what was not whole is cut off when the file is opened again.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/campaign/sample_record.h"

namespace unlatch::hil {

// Not readable, of another campaign, or not writable (a full disk); what() names the file.
class ResultError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ResultFile {
 public:
  // A new file; one that is there is replaced. Throws ResultError.
  static ResultFile create(const std::string& path, const ResultShape& shape);
  // Opens one and cuts off a record that is not whole; `writable`: for append().
  static ResultFile open(const std::string& path, bool writable);
  ~ResultFile();
  ResultFile(ResultFile&& other) noexcept;
  ResultFile& operator=(ResultFile&&) = delete;

  const ResultShape& shape() const { return shape_; }
  // The samples of the whole records, in the order of the file; those after a damaged one included, that one not.
  const std::vector<std::int64_t>& samples() const { return samples_; }
  [[nodiscard]] SampleRecord read(std::size_t record) const;
  // Throws ResultError; then the file ends with its last whole record.
  void append(const SampleRecord& record);

 private:
  ResultFile(int file, std::string path) : file_(file), path_(std::move(path)) {}
  void scan(bool writable);

  int file_ = -1;
  std::string path_;
  ResultShape shape_;
  std::vector<std::int64_t> samples_;
  std::vector<std::uint64_t> places_;  // bytes from the begin of the file
  std::uint64_t end_ = 0;              // of the last whole record
};

}  // namespace unlatch::hil
