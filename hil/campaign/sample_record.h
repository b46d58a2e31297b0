// The result of one sample, and its bytes: in the file of results, and from one process to another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/campaign/campaign.h"
#include "hil/evaluation/evaluation.h"

namespace unlatch::hil {

// Numbers in a record, and all that decides them: files of one shape can be merged.
struct ResultShape {
  std::uint64_t fingerprint = 0;
  std::uint32_t inputs = 0, values = 0;
  bool operator==(const ResultShape&) const = default;
};
ResultShape get_shape(const Campaign& campaign, const SampleEvaluator& evaluator);

struct SampleRecord {
  std::int64_t sample = 0;
  std::vector<double> inputs;
  SampleResult result;  // its message cut to 120 bytes
};

// Of one sample: its number, inputs, status, hashes and values, to the bit.
std::uint64_t calc_hash(const SampleRecord& record);
// Adds one sample to the hash of a campaign: the order does not matter.
constexpr std::uint64_t add_to_hash(std::uint64_t campaign, std::uint64_t sample) { return campaign + sample; }

// A record's bytes: as many for every sample of one shape; little endian, with a checksum at the end.
std::size_t get_record_bytes(const ResultShape& shape);
// `to` has get_record_bytes(). Numbers that are none become one and the same NaN.
void encode_record(const ResultShape& shape, const SampleRecord& record, std::span<char> to);
// Nothing if these bytes, of any origin, are no record: another size, a wrong checksum, no sample, no status of a
// sample that ended.
std::optional<SampleRecord> decode_record(const ResultShape& shape, std::span<const char> bytes);
// Of whole words; the rest of the bytes is left out.
std::uint64_t calc_checksum(std::span<const char> bytes);

// FNV-1a over bytes.
std::uint64_t calc_digest(const std::string& text);

}  // namespace unlatch::hil
