#include "hil/campaign/result_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace unlatch::hil {
namespace {

// Little endian, as all machines that this runs on.
constexpr char kMagic[8] = {'U', 'N', 'L', 'C', 'A', 'M', 'P', '1'};
constexpr std::size_t kMessage = 120;

struct Header {
  char magic[8];
  std::uint64_t fingerprint;
  std::uint32_t inputs, values;
  std::uint64_t checksum;
};

struct RecordHead {
  std::int64_t sample, status, ticks, hash, model_hash;
};

std::uint64_t mix(std::uint64_t h) {  // the finaliser of MurmurHash3: each bit of the input changes half of the output
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

std::uint64_t calc_checksum(const char* bytes, std::size_t count) {
  Digest digest;
  for (; count >= 8; bytes += 8, count -= 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, 8);
    digest.add(word);
  }
  return digest.get();
}

[[noreturn]] void fail(const std::string& path, const std::string& what) { throw ResultError(path + ": " + what); }

bool read_whole(int file, char* to, std::size_t count, std::uint64_t at) {
  while (count > 0) {
    const ssize_t got = pread(file, to, count, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    at += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

bool write_whole(int file, const char* from, std::size_t count, std::uint64_t at) {
  while (count > 0) {
    const ssize_t put = pwrite(file, from, count, static_cast<off_t>(at));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    from += put;
    at += static_cast<std::uint64_t>(put);
    count -= static_cast<std::size_t>(put);
  }
  return true;
}

}  // namespace

std::uint64_t calc_digest(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

// The scenario's text and overrides, the campaign's text, its tables by what they give, and the columns.
ResultShape get_shape(const Campaign& campaign, const SampleEvaluator& evaluator) {
  Digest digest;
  const Scenario& scenario = campaign.tree->get_nominal();
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

ResultFile::~ResultFile() {
  if (file_ >= 0) close(file_);
}

ResultFile::ResultFile(ResultFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      path_(std::move(other.path_)),
      shape_(other.shape_),
      samples_(std::move(other.samples_)),
      places_(std::move(other.places_)),
      end_(other.end_) {}

ResultFile ResultFile::create(const std::string& path, const ResultShape& shape) {
  ResultFile file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666), path);
  if (file.file_ < 0) fail(path, std::string("it cannot be written: ") + std::strerror(errno));
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.fingerprint = shape.fingerprint;
  header.inputs = shape.inputs;
  header.values = shape.values;
  header.checksum = calc_checksum(reinterpret_cast<const char*>(&header), offsetof(Header, checksum));
  if (!write_whole(file.file_, reinterpret_cast<const char*>(&header), sizeof header, 0))
    fail(path, std::string("it cannot be written: ") + std::strerror(errno));
  file.shape_ = shape;
  file.end_ = sizeof header;
  return file;
}

ResultFile ResultFile::open(const std::string& path, bool writable) {
  ResultFile file(::open(path.c_str(), (writable ? O_RDWR : O_RDONLY) | O_CLOEXEC), path);
  if (file.file_ < 0) fail(path, std::string("it cannot be opened: ") + std::strerror(errno));
  Header header{};
  const auto* const bytes = reinterpret_cast<const char*>(&header);
  if (!read_whole(file.file_, reinterpret_cast<char*>(&header), sizeof header, 0) ||
      std::memcmp(header.magic, kMagic, sizeof kMagic) != 0 ||
      header.checksum != calc_checksum(bytes, offsetof(Header, checksum)))
    fail(path, "this is no file of a campaign's results");
  file.shape_ = {header.fingerprint, header.inputs, header.values};
  file.scan(writable);
  return file;
}

std::size_t ResultFile::get_record_bytes() const {
  return sizeof(RecordHead) + 8 * (std::size_t{shape_.inputs} + shape_.values) + kMessage + 8;
}

void ResultFile::scan(bool writable) {
  struct stat status {};
  if (fstat(file_, &status) != 0) fail(path_, std::strerror(errno));
  const std::size_t bytes = get_record_bytes();
  const auto size = static_cast<std::uint64_t>(status.st_size);
  std::vector<char> record(bytes);
  end_ = sizeof(Header);
  for (std::uint64_t at = end_; at + bytes <= size; at += bytes) {
    if (!read_whole(file_, record.data(), bytes, at)) fail(path_, std::strerror(errno));
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, record.data() + bytes - 8, 8);
    if (checksum != calc_checksum(record.data(), bytes - 8)) continue;
    RecordHead head{};
    std::memcpy(&head, record.data(), sizeof head);
    samples_.push_back(head.sample);
    places_.push_back(at);
    end_ = at + bytes;
  }
  if (writable && ftruncate(file_, static_cast<off_t>(end_)) != 0)
    fail(path_, std::string("it cannot be written: ") + std::strerror(errno));
}

SampleRecord ResultFile::read(std::size_t index) const {
  const std::size_t bytes = get_record_bytes();
  std::vector<char> buffer(bytes);
  if (!read_whole(file_, buffer.data(), bytes, places_.at(index))) fail(path_, "it cannot be read");
  RecordHead head{};
  std::memcpy(&head, buffer.data(), sizeof head);
  const char* at = buffer.data() + sizeof head;
  SampleRecord record;
  record.sample = head.sample;
  record.result.status = static_cast<SampleStatus>(head.status);
  record.result.ticks = head.ticks;
  record.result.hash = head.hash;
  record.result.model_hash = head.model_hash;
  record.inputs.resize(shape_.inputs);
  record.result.values.resize(shape_.values);
  for (std::vector<double>* values : {&record.inputs, &record.result.values}) {
    std::memcpy(values->data(), at, 8 * values->size());
    at += 8 * values->size();
  }
  record.result.message.assign(at, strnlen(at, kMessage));
  return record;
}

void ResultFile::append(const SampleRecord& record) {
  std::vector<char> buffer(get_record_bytes());
  const RecordHead head{record.sample, static_cast<std::int64_t>(record.result.status), record.result.ticks,
                        record.result.hash, record.result.model_hash};
  std::memcpy(buffer.data(), &head, sizeof head);
  char* at = buffer.data() + sizeof head;
  for (const std::vector<double>* values : {&record.inputs, &record.result.values}) {
    for (double value : *values) {
      if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();  // one of them
      std::memcpy(at, &value, 8);
      at += 8;
    }
  }
  std::memcpy(at, record.result.message.data(), std::min(kMessage, record.result.message.size()));
  const std::uint64_t checksum = calc_checksum(buffer.data(), buffer.size() - 8);
  std::memcpy(buffer.data() + buffer.size() - 8, &checksum, 8);
  if (!write_whole(file_, buffer.data(), buffer.size(), end_)) {
    const std::string why = std::strerror(errno);
    if (ftruncate(file_, static_cast<off_t>(end_)) != 0) fail(path_, "it cannot be written: " + why);
    fail(path_, "it cannot be written: " + why + "; " + std::to_string(samples_.size()) + " samples are in it");
  }
  samples_.push_back(record.sample);
  places_.push_back(end_);
  end_ += buffer.size();
}

}  // namespace unlatch::hil
