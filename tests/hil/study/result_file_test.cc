// Facts about the result file: it may be cut anywhere, or its disk may be full; its complete records are read.
#include "hil/study/campaign/samples/result_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "hil/study/campaign/samples/result_table.h"

namespace unlatch::test::result_file_test {
namespace {

namespace fs = std::filesystem;

using hil::ResultFile;
using hil::ResultShape;
using hil::SampleRecord;

class ResultFileTest : public testing::Test {
 protected:
  const std::string path_ = (fs::path(testing::TempDir()) / ("results_" + std::to_string(getpid()) + ".bin")).string();
  const ResultShape shape_{42, 2, 3};
  void TearDown() override { fs::remove(path_); }

  static SampleRecord make(std::int64_t sample) {
    SampleRecord record;
    record.sample = sample;
    record.inputs = {0.5 * static_cast<double>(sample), -1};
    record.result.values = {1, std::nan(""), static_cast<double>(sample)};
    record.result.hash = sample * 77;
    record.result.message = sample == 1 ? "pivot at joint 'nose1'" : "";
    return record;
  }
  void fill(std::int64_t count) {
    ResultFile file = ResultFile::create(path_, shape_);
    for (std::int64_t i = 0; i < count; ++i) file.append(make(i));
  }
};

TEST_F(ResultFileTest, GivesBackWhatWasAdded) {
  fill(3);
  const ResultFile file = ResultFile::open(path_, false);
  EXPECT_EQ(file.shape(), shape_);
  ASSERT_EQ(file.samples(), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(calc_hash(file.read(2)), calc_hash(make(2)));
  EXPECT_EQ(file.read(1).result.message, "pivot at joint 'nose1'");
}

TEST_F(ResultFileTest, CutAtAnyByteKeepsTheWholeRecords) {
  fill(3);
  const auto bytes = fs::file_size(path_);
  ResultFile::create(path_, shape_);
  const auto header = fs::file_size(path_), record = (bytes - header) / 3;
  for (auto cut = header; cut < bytes; ++cut) {
    fill(3);
    fs::resize_file(path_, cut);
    ResultFile file = ResultFile::open(path_, true);
    EXPECT_EQ(file.samples().size(), (cut - header) / record) << cut;
    file.append(make(9));
    EXPECT_EQ(ResultFile::open(path_, false).samples().back(), 9) << cut;
  }
}

TEST_F(ResultFileTest, ADamagedRecordIsLeftOut) {
  fill(3);
  {
    std::fstream stream(path_, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(fs::file_size(path_) / 2));
    stream.put('x');
  }
  EXPECT_EQ(ResultFile::open(path_, false).samples(), (std::vector<std::int64_t>{0, 2}));
}

TEST_F(ResultFileTest, AFullDiskIsAnErrorAndTheFileStaysWhole) {
  fill(2);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    ResultFile file = ResultFile::open(path_, true);
    const rlimit full{fs::file_size(path_) + 50, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
    EXPECT_THROW(file.append(make(2)), hil::ResultError);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  }
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(ResultFile::open(path_, false).samples().size(), 2u);
}

TEST_F(ResultFileTest, BytesThatAreNoRecordAreRefused) {
  std::vector<char> bytes(get_record_bytes(shape_));
  encode_record(shape_, make(4), bytes);
  ASSERT_TRUE(decode_record(shape_, bytes));
  EXPECT_EQ(calc_hash(*decode_record(shape_, bytes)), calc_hash(make(4)));
  for (std::size_t count = 0; count < bytes.size(); ++count)
    EXPECT_FALSE(decode_record(shape_, std::span<const char>(bytes).first(count)));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<char> changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    EXPECT_FALSE(decode_record(shape_, changed)) << i;
  }
  // Records with a valid checksum: a sample below 0, an unknown status, and one of an unfinished sample.
  for (const auto& [sample, status] : {std::pair{-1, 0}, std::pair{4, 4}, std::pair{4, -1}, std::pair{4, 99}}) {
    SampleRecord record = make(4);
    record.sample = sample;
    record.result.status = static_cast<hil::SampleStatus>(status);
    encode_record(shape_, record, bytes);
    EXPECT_FALSE(decode_record(shape_, bytes)) << sample << " " << status;
  }
}

// Header in the form on disk, with a valid checksum: eight letters, fingerprint, counts, checksum.
TEST_F(ResultFileTest, AForgedHeaderIsNotBelieved) {
  for (const auto& [inputs, values] :
       {std::pair{4294967295u, 4294967295u}, std::pair{4294967295u, 0u}, std::pair{1000000u, 3u}, std::pair{0u, 0u}}) {
    fill(3);
    std::fstream stream(path_, std::ios::in | std::ios::out | std::ios::binary);
    char header[32];
    stream.read(header, sizeof header);
    std::memcpy(header + 16, &inputs, 4);
    std::memcpy(header + 20, &values, 4);
    const std::uint64_t checksum = hil::calc_checksum({header, 24});
    std::memcpy(header + 24, &checksum, 8);
    stream.seekp(0);
    stream.write(header, sizeof header);
    stream.close();
    const ResultFile file = ResultFile::open(path_, true);
    EXPECT_EQ(file.shape().inputs, inputs);
    EXPECT_TRUE(file.samples().empty());
  }
}

// Bytes changed, lost and added anywhere: every record read is one of those written.
TEST_F(ResultFileTest, ADamagedFileGivesWholeRecordsOrARefusal) {
  constexpr int kTrials = 3000, kRecords = 6;
  fill(kRecords);
  std::string whole;
  {
    std::ostringstream text;
    text << std::ifstream(path_, std::ios::binary).rdbuf();
    whole = text.str();
  }
  const unsigned seed = 20260727;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int opened = 0, refused = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string bytes = whole;
    for (auto k = random() % 4; k-- > 0 && !bytes.empty();) {
      const std::size_t at = random() % (trial % 2 == 0 ? 40 : bytes.size());
      if (at >= bytes.size()) continue;
      const auto kind = random() % 4;
      if (kind == 0) bytes[at] = static_cast<char>(random());
      if (kind == 1) bytes.erase(at, random() % 30);
      if (kind == 2) bytes.insert(at, random() % 30, static_cast<char>(random()));
      if (kind == 3) bytes.resize(at);
    }
    if (random() % 4 == 0 && bytes.size() >= 32) {  // with a valid checksum of the header
      const std::uint64_t checksum = hil::calc_checksum({bytes.data(), 24});
      std::memcpy(bytes.data() + 24, &checksum, 8);
    }
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    try {
      const ResultFile file = ResultFile::open(path_, trial % 3 == 0);
      for (std::size_t i = 0; i < file.samples().size() && file.shape() == shape_; ++i)
        EXPECT_EQ(calc_hash(file.read(i)), calc_hash(make(file.samples()[i])));
      ++opened;
    } catch (const hil::ResultError&) {
      ++refused;
    }
  }
  EXPECT_GT(opened, kTrials / 10);
  EXPECT_GT(refused, kTrials / 10);
}

TEST_F(ResultFileTest, ATableHasEachSampleOnceInTheOrderOfTheirNumbers) {
  {
    ResultFile file = ResultFile::create(path_, shape_);
    for (const int sample : {7, 2, 9, 2, 4}) file.append(make(sample));
    SampleRecord again = make(9);  // the first one counts
    again.inputs[0] = 100;
    again.result.status = hil::SampleStatus::kFaulted;
    file.append(again);
  }
  const hil::ResultTable table(ResultFile::open(path_, false));
  const std::vector<std::int64_t> samples{2, 4, 7, 9};
  ASSERT_EQ(table.size(), samples.size());
  std::uint64_t hash = 0;
  for (std::size_t row = 0; row < samples.size(); ++row) {
    EXPECT_EQ(table.get_sample(row), samples[row]);
    EXPECT_EQ(table.get_status(row), hil::SampleStatus::kDone);
    EXPECT_EQ(calc_hash(table.read(row)), calc_hash(make(samples[row])));
    EXPECT_EQ(table.find(samples[row]), row);
    hash = hil::add_to_hash(hash, calc_hash(make(samples[row])));
  }
  EXPECT_EQ(table.hash(), hash);
  EXPECT_EQ(table.find(3), 1u);
  EXPECT_EQ(table.find(10), 4u);
}

// Whatever number of columns is read together.
TEST_F(ResultFileTest, ATableHasTheColumnsInAnyOrder) {
  constexpr std::size_t kRows = 50;
  fill(kRows);
  for (const std::size_t batch : {std::size_t{1}, 2 * kRows, 4 * kRows, hil::ResultTable::kBatch}) {
    const hil::ResultTable table(ResultFile::open(path_, false), batch);
    for (const std::size_t column : {4u, 0u, 3u, 2u, 1u, 4u}) {
      const std::vector<double> values = table.read_column(column, kRows - 1);
      ASSERT_EQ(values.size(), kRows - 1);
      for (std::size_t row = 0; row < values.size(); ++row) {
        const SampleRecord record = make(static_cast<std::int64_t>(row));
        const double expected = column < 2 ? record.inputs[column] : record.result.values[column - 2];
        EXPECT_EQ(std::isnan(values[row]), std::isnan(expected));
        if (!std::isnan(expected)) {
          EXPECT_EQ(values[row], expected) << batch << " " << column << " " << row;
        }
      }
    }
  }
}

TEST_F(ResultFileTest, OtherFilesAreRefused) {
  std::ofstream(path_) << "not results";
  EXPECT_THROW(ResultFile::open(path_, false), hil::ResultError);
  EXPECT_THROW(ResultFile::open(path_ + ".none", false), hil::ResultError);
}

TEST_F(ResultFileTest, HashSeesEveryPartOfASample) {
  const std::uint64_t hash = calc_hash(make(1));
  for (const auto& change : std::vector<void (*)(SampleRecord&)>{
           [](SampleRecord& r) { r.sample = 2; }, [](SampleRecord& r) { r.inputs[0] = 0.25; },
           [](SampleRecord& r) { r.result.values[2] = -0.0; }, [](SampleRecord& r) { r.result.hash ^= 1; },
           [](SampleRecord& r) { r.result.model_hash ^= 1; }, [](SampleRecord& r) { r.result.ticks += 1; },
           [](SampleRecord& r) { r.result.status = hil::SampleStatus::kFaulted; }}) {
    SampleRecord record = make(1);
    change(record);
    EXPECT_NE(calc_hash(record), hash);
  }
}

}  // namespace
}  // namespace unlatch::test::result_file_test
