// Recordings: their contents, and the reader's results for damaged ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "tests/hil/session/session_support.h"

namespace unlatch::test::recorder_test {
namespace {

using hil::LogFileReader;
using hil::Pace;

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
      hil::StateMessage state;
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

// Results of reading a file's bytes: the ticks, and the completeness of the recording.
struct Found {
  std::vector<std::int64_t> hashes;  // hashes of the ticks
  bool complete = false, damaged = false;
};

Found find_ticks(const std::string& bytes) {
  Found found;
  MemoryFile memory(bytes);
  try {
    hil::RecordingReader reader(memory.open());
    hil::LogTick tick;
    while (reader.next(tick)) found.hashes.push_back(tick.hash);
    found.complete = reader.end.has_value();
    found.damaged = reader.damaged;
    EXPECT_NE(found.complete, !reader.shortfall.empty()) << "either whole or a sentence why not";
  } catch (const hil::LogError&) {  // the header is incomplete
  }
  return found;
}

bool is_beginning_of(const std::vector<std::int64_t>& part, const std::vector<std::int64_t>& whole) {
  return part.size() <= whole.size() && std::equal(part.begin(), part.end(), whole.begin());
}

// Every prefix of a recording is a recording of its complete ticks.
TEST(Recording, CutAnywhereItHoldsEveryTickThatIsComplete) {
  const std::string whole = read_bytes(record("log"));
  const Found all = find_ticks(whole);
  ASSERT_TRUE(all.complete);
  ASSERT_EQ(all.hashes.size(), 50u);
  std::size_t ticks = 0;
  for (std::size_t length = 1; length < whole.size(); ++length) {
    const Found found = find_ticks(whole.substr(0, length));
    ASSERT_FALSE(found.complete || found.damaged) << "cut to " << length;
    ASSERT_TRUE(is_beginning_of(found.hashes, all.hashes)) << "cut to " << length;
    ASSERT_TRUE(found.hashes.size() == ticks || found.hashes.size() == ticks + 1) << "cut to " << length;
    ticks = found.hashes.size();
  }
  EXPECT_EQ(ticks, 50u);
}

TEST(Recording, AFlippedByteAnywhereIsNoticedAndNothingAfterItIsBelieved) {
  const std::string whole = read_bytes(record("log"));
  const Found all = find_ticks(whole);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << at % 8));
    const Found found = find_ticks(bytes);
    ASSERT_FALSE(found.complete) << "byte " << at << " of " << whole.size();
    ASSERT_TRUE(is_beginning_of(found.hashes, all.hashes)) << "byte " << at;
    ASSERT_LE(found.hashes.size(), find_ticks(whole.substr(0, at + 1)).hashes.size()) << "byte " << at;
  }
}

TEST(Recording, CutAnywhereItReplays) {
  const std::string whole = read_bytes(record("log"));
  const std::string path = make_path("cut");
  const std::size_t header = whole.find(hil::kTickChannel);  // before it there is nothing to replay
  for (std::size_t length = header + 61; length < whole.size(); length += 997) {
    write_bytes(path, whole.substr(0, length));
    const ReplayedLog replayed = replay_log(path);
    EXPECT_TRUE(replayed.result.agrees());
    EXPECT_FALSE(replayed.complete);
    EXPECT_EQ(replayed.result.compared, static_cast<std::int64_t>(find_ticks(whole.substr(0, length)).hashes.size()));
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

// A tiny ring, and a cyclic thread that does not wait, as in real time.
TEST(Recording, WhatTheRingHadNoRoomForIsCountedAndTheRecordingIsNotReplayable) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto simulation = hil::build_simulation(scenario);
  const std::string path = make_path("log");
  constexpr std::int64_t kTicks = 50;
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kRealtime, 1, kTicks), 4);
  for (std::int64_t tick = 0; tick < kTicks; ++tick) {
    recorder.change({0, hil::ChangeCause::kCommand, 7, tick + 1, 0.5});
    recorder.tick(tick, simulation->calc_hash());
    ASSERT_EQ(simulation->step().status, StepStatus::kOk);
  }
  hil::LogEnd end;
  end.tick = kTicks;
  end.hash = simulation->calc_hash();
  recorder.close(end);
  ASSERT_GT(end.unrecorded, 0) << "100 items at once do not fit a ring of four";

  hil::RecordingReader reader{LogFileReader(path)};
  hil::LogTick tick;
  std::int64_t ticks = 0;
  while (reader.next(tick)) ++ticks;
  ASSERT_TRUE(reader.end) << reader.shortfall;
  EXPECT_EQ(reader.end->unrecorded, end.unrecorded);
  EXPECT_LT(ticks, kTicks);
  try {
    replay_log(path);
    ADD_FAILURE() << "replayed";
  } catch (const hil::LogError& error) {
    EXPECT_THAT(error.what(), testing::ContainsRegex("not replayable: [1-9][0-9]* of its items"));  // lost by then
  }
}

TEST(Recording, AtOtherPacesTheCyclicThreadWaitsForRoom) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::string path = make_path("log");
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 50), 4);
  const std::atomic<bool> stop{false};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, 50, stop, [] {});
  recorder.close(end);
  EXPECT_EQ(end.unrecorded, 0);
  EXPECT_EQ(end.states_unrecorded, 0);
  EXPECT_EQ(replay_log(path).result.compared, 51);
}

TEST(Recording, ChecksumIsCrc64Xz) {
  const std::string check = "123456789";  // the catalogue's check input
  EXPECT_EQ(hil::calc_crc64({reinterpret_cast<const std::uint8_t*>(check.data()), check.size()}), 0x995DC9BBDF1939FAu);
}

}  // namespace
}  // namespace unlatch::test::recorder_test
