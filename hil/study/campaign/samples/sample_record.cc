#include "hil/study/campaign/samples/sample_record.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace unlatch::hil {
namespace {

constexpr std::size_t kMessage = 120;

struct RecordHead {
  std::int64_t sample, status, ticks, hash, model_hash;
};

std::uint64_t mix(std::uint64_t h) {  // finaliser of MurmurHash3: each bit of the input changes half of the output bits
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdu;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53u;
  return h ^ h >> 33;
}

class Digest {
 public:
  void add(std::uint64_t word) { state_ = mix(state_ ^ word) + 0x9E3779B97F4A7C15u; }
  void add(const std::vector<double>& values) {
    for (const double value : values) add(std::bit_cast<std::uint64_t>(value));
  }
  [[nodiscard]] std::uint64_t get() const { return mix(state_); }

 private:
  std::uint64_t state_ = 0x243F6A8885A308D3u;  // pi
};

// Hash of the state after the first steps of the scenario as it is: a program with other physics has another one, even
// of the same version.
std::int64_t calc_physics(const SampleEvaluator& evaluator) {
  constexpr int kSteps = 8;
  SampleRun run;
  run.until = kSteps * evaluator.tree().get_nominal().dt;
  run.judges = false;
  const std::atomic<bool> never{false};
  return evaluator.evaluate({}, never, run).hash;
}

}  // namespace

std::uint64_t calc_checksum(std::span<const char> bytes) {
  Digest digest;
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), 8);
    digest.add(word);
  }
  return digest.get();
}

std::uint64_t calc_digest(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

std::string get_program_version() { return "unlatch " UNLATCH_VERSION; }

// Shape of the results: the program's version and physics, the scenario's text and overrides, the campaign's text, the
// contents of its tables, and the columns. The texts begin with the versions of their languages.
ResultShape get_shape(const Campaign& campaign, const SampleEvaluator& evaluator, const std::string& program) {
  Digest digest;
  const Scenario& scenario = campaign.tree->get_nominal();
  digest.add(calc_digest(program));
  digest.add(static_cast<std::uint64_t>(calc_physics(evaluator)));
  digest.add(calc_digest(campaign.text));
  digest.add(calc_digest(scenario.text));
  for (const std::string& text : scenario.overrides) digest.add(calc_digest(text));
  for (const CampaignParameter& parameter : campaign.parameters) digest.add(parameter.distribution.values);
  for (const std::vector<double>& row : campaign.table) digest.add(row);
  const std::vector<InputColumn> inputs = list_inputs(campaign);
  for (const InputColumn& input : inputs) digest.add(calc_digest(input.name));
  for (const ResultColumn& column : evaluator.columns()) digest.add(calc_digest(column.name));
  return {digest.get(), static_cast<std::uint32_t>(inputs.size()),
          static_cast<std::uint32_t>(evaluator.columns().size())};
}

std::uint64_t calc_hash(const SampleRecord& record) {
  Digest digest;
  digest.add(static_cast<std::uint64_t>(record.sample));
  digest.add(static_cast<std::uint64_t>(record.result.status));
  digest.add(static_cast<std::uint64_t>(record.result.ticks));
  digest.add(static_cast<std::uint64_t>(record.result.hash));
  digest.add(static_cast<std::uint64_t>(record.result.model_hash));
  digest.add(record.inputs);
  digest.add(record.result.values);
  return digest.get();
}

std::size_t get_record_bytes(const ResultShape& shape) {
  return sizeof(RecordHead) + 8 * (std::size_t{shape.inputs} + shape.values) + kMessage + 8;
}

std::size_t get_number_place(std::size_t number) { return sizeof(RecordHead) + sizeof(double) * number; }

void encode_record(const ResultShape& shape, const SampleRecord& record, std::span<char> to) {
  std::fill(to.begin(), to.end(), char{0});
  const RecordHead head{record.sample, static_cast<std::int64_t>(record.result.status), record.result.ticks,
                        record.result.hash, record.result.model_hash};
  std::memcpy(to.data(), &head, sizeof head);
  std::size_t at = get_number_place(0);
  for (const auto& [values, count] :
       {std::pair{&record.inputs, shape.inputs}, std::pair{&record.result.values, shape.values}}) {
    for (std::size_t i = 0; i < count; ++i, at += 8) {
      const double value = std::isnan(values->at(i)) ? std::numeric_limits<double>::quiet_NaN() : (*values)[i];
      std::memcpy(to.data() + at, &value, 8);
    }
  }
  std::memcpy(to.data() + at, record.result.message.data(), std::min(kMessage, record.result.message.size()));
  const std::uint64_t checksum = calc_checksum(to.first(to.size() - 8));
  std::memcpy(to.data() + to.size() - 8, &checksum, 8);
}

std::optional<SampleRecord> decode_record(const ResultShape& shape, std::span<const char> bytes) {
  if (bytes.size() != get_record_bytes(shape)) return std::nullopt;
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, bytes.data() + bytes.size() - 8, 8);
  RecordHead head{};
  std::memcpy(&head, bytes.data(), sizeof head);
  if (checksum != calc_checksum(bytes.first(bytes.size() - 8)) || head.sample < 0 || head.status < 0 ||
      head.status >= static_cast<std::int64_t>(SampleStatus::kInterrupted))
    return std::nullopt;
  SampleRecord record;
  record.sample = head.sample;
  record.result.status = static_cast<SampleStatus>(head.status);
  record.result.ticks = head.ticks;
  record.result.hash = head.hash;
  record.result.model_hash = head.model_hash;
  record.inputs.resize(shape.inputs);
  record.result.values.resize(shape.values);
  const char* at = bytes.data() + get_number_place(0);
  for (std::vector<double>* values : {&record.inputs, &record.result.values}) {
    std::memcpy(values->data(), at, 8 * values->size());
    at += 8 * values->size();
  }
  record.result.message.assign(at, strnlen(at, kMessage));
  return record;
}

}  // namespace unlatch::hil
