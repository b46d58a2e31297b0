// The result of one sample, and its bytes: in the result file, and between processes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/study/campaign/campaign.h"
#include "hil/study/evaluation/evaluation.h"

namespace unlatch::hil {

// "unlatch 0.1.0"
std::string get_program_version();

// Numbers in a record, and everything that determines them: files of one shape can be merged.
struct ResultShape {
  std::uint64_t fingerprint = 0;
  std::uint32_t inputs = 0, values = 0;
  bool operator==(const ResultShape&) const = default;
};
// `program`: name and version of the program that runs the samples.
ResultShape get_shape(const Campaign& campaign, const SampleEvaluator& evaluator,
                      const std::string& program = get_program_version());

struct SampleRecord {
  std::int64_t sample = 0;
  std::vector<double> inputs;
  SampleResult result;  // message cut to 120 bytes
};

// Hash of one sample: its number, inputs, status, hashes and values, bit by bit.
std::uint64_t calc_hash(const SampleRecord& record);
// Adds one sample to the hash of a campaign, independent of the order.
constexpr std::uint64_t add_to_hash(std::uint64_t campaign, std::uint64_t sample) { return campaign + sample; }

// Size of a record, the same for every sample of one shape; little-endian, with a checksum at the end.
std::size_t get_record_bytes(const ResultShape& shape);
// Place of a number in a record, bytes from its beginning; inputs are the first, then values.
std::size_t get_number_place(std::size_t number);
// Encodes a record into `to` of get_record_bytes(). Every NaN becomes the same NaN.
void encode_record(const ResultShape& shape, const SampleRecord& record, std::span<char> to);
// Decodes bytes of any origin. Returns nothing if they are no record: another size, a wrong checksum, no sample, or no
// status of a finished sample.
std::optional<SampleRecord> decode_record(const ResultShape& shape, std::span<const char> bytes);
// Checksum of the whole words; the rest of the bytes is left out.
std::uint64_t calc_checksum(std::span<const char> bytes);

// FNV-1a hash of the bytes.
std::uint64_t calc_digest(const std::string& text);

}  // namespace unlatch::hil
