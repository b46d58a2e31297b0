// Recordings: what they hold, and what a reader makes of damaged ones.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/session_support.h"

namespace unlatch::test {
namespace {

using hil::LogFileReader;
using hil::Pace;

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string record(const std::string& name) {
  const std::string path = make_path(name);
  EXPECT_EQ(run_session(Pace::kLockstep, {}, path).end.status, hil::RunStatus::kDone);
  return path;
}

TEST(Recording, IsReadByLcmItself) {
  const std::string path = record("log");
  lcm::LogFile file(path, "r");
  ASSERT_TRUE(file.good());
  int states = 0, ticks = 0;
  std::int64_t last_us = 0;
  while (const lcm::LogEvent* event = file.readNextEvent()) {
    EXPECT_GE(event->timestamp, last_us);
    last_us = event->timestamp;
    if (event->channel == hil::get_channel(hil::MessageKind::kState)) {
      hil::State state;
      ASSERT_TRUE(
          decode({static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)}, state));
      EXPECT_EQ(state.tick, event->timestamp / 1000);
      EXPECT_EQ(state.body_count, 2);
      ++states;
    }
    ticks += event->channel == hil::kTickChannel;
  }
  EXPECT_EQ(states, 6);  // every 10 ms of 50 ms, both ends
  EXPECT_EQ(ticks, 50);
}

// Every prefix of a recording is a recording of the ticks that are complete in it.
TEST(Recording, CutAnywhereItReplaysUpToItsLastCompleteRecord) {
  const std::string whole = read_bytes(record("log"));
  const std::string path = make_path("cut");
  std::int64_t compared = 0, shorter = 0;
  for (std::size_t length = 0; length < whole.size(); length += 61) {
    write_bytes(path, whole.substr(0, length));
    try {
      const ReplayedLog replayed = replay_log(path);
      EXPECT_TRUE(replayed.result.agrees());
      EXPECT_FALSE(replayed.complete);
      EXPECT_FALSE(replayed.shortfall.empty());
      EXPECT_GE(replayed.result.compared, compared);
      compared = replayed.result.compared;
    } catch (const hil::LogError&) {
      ++shorter;  // not even its header is complete
    }
  }
  EXPECT_GT(shorter, 0);
  EXPECT_EQ(compared, 50);
}

TEST(Recording, AFlippedByteAnywhereIsNoticed) {
  const std::string whole = read_bytes(record("log"));
  const std::string path = make_path("flipped");
  for (std::size_t at = 3; at < whole.size(); at += 97) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_bytes(path, bytes);
    bool noticed = false;
    try {
      const ReplayedLog replayed = replay_log(path);
      noticed = !replayed.complete;
      EXPECT_TRUE(replayed.result.agrees()) << "what is intact agrees, byte " << at;
    } catch (const hil::LogError&) {
      noticed = true;
    }
    EXPECT_TRUE(noticed) << "byte " << at << " of " << whole.size();
  }
}

TEST(Recording, ForeignFilesAreRefusedByName) {
  const std::string path = make_path("foreign");
  const auto complaint = [&path] {
    try {
      hil::RecordingReader reader{LogFileReader(path)};
    } catch (const hil::LogError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  write_bytes(path, "");
  EXPECT_NE(complaint().find("is empty"), std::string::npos);
  write_bytes(path, "unlatch: 1\nname: a scenario, not a recording of one\n");
  EXPECT_NE(complaint().find("is not a recording"), std::string::npos);
  {
    lcm::LogFile file(path, "w");
    std::uint8_t byte = 1;
    lcm::LogEvent event;
    event.timestamp = 1;
    event.channel = "SOMEBODY_ELSE";
    event.datalen = 1;
    event.data = &byte;
    file.writeEvent(&event);
  }
  EXPECT_NE(complaint().find("SOMEBODY_ELSE"), std::string::npos);
}

TEST(Recording, AnotherVersionOrSchemaIsRefusedByName) {
  const std::string path = make_path("other");
  const auto complaint = [&path](const hil::LogHeader& header) {
    std::vector<std::uint8_t> bytes;
    encode(header, bytes);
    {
      hil::LogFileWriter writer(path);
      writer.append(0, hil::kHeaderChannel, bytes);
    }
    try {
      hil::RecordingReader reader{LogFileReader(path)};
    } catch (const hil::LogError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  hil::LogHeader header;
  EXPECT_EQ(complaint(header), "accepted");
  header.version = 99;
  EXPECT_NE(complaint(header).find("log version 99"), std::string::npos);
  header.version = hil::kLogVersion;
  header.schema_hash ^= 1;
  EXPECT_NE(complaint(header).find("message schema"), std::string::npos);
}

TEST(Recording, AFolderThatCannotBeWrittenIsAnError) {
  EXPECT_THROW(hil::LogFileWriter("/nonexistent/folder/run.log"), hil::LogWriteError);
}

TEST(Recording, AFullDiskIsSaidNotSwallowed) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  hil::LogFileWriter writer("/dev/full");
  const std::vector<std::uint8_t> data(100);
  writer.append(0, "SOME_CHANNEL", data);
  EXPECT_FALSE(writer.flush());
  EXPECT_NE(writer.get_error().find("/dev/full: cannot be written"), std::string::npos) << writer.get_error();
  EXPECT_FALSE(writer.append(0, "SOME_CHANNEL", data));
}

TEST(Recording, ChecksumIsCrc64Xz) {
  const std::string check = "123456789";  // the catalogue's check input
  EXPECT_EQ(hil::calc_crc64({reinterpret_cast<const std::uint8_t*>(check.data()), check.size()}), 0x995DC9BBDF1939FAu);
}

}  // namespace
}  // namespace unlatch::test
