// Facts about hostile use of the C library: null, closed and foreign handles, wrong arguments, two threads, mistakes in
// scenarios. None of it ends the process, and every refusal has a text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <locale>
#include <thread>

#include "tests/library/handles.h"

namespace unlatch::test::hostile_use_test {
namespace {

using testing::HasSubstr;

// The host's locale: tests/support/comma_locale.sh names one with a decimal comma.
class HostLocale final : public testing::Environment {
  void SetUp() override {
    if (const char* const name = std::getenv("UNLATCH_LOCALE")) std::locale::global(std::locale(name));
  }
};
const testing::Environment* const kHostLocale = testing::AddGlobalTestEnvironment(new HostLocale);

// Every function that takes a handle, with otherwise valid arguments.
std::vector<std::function<unlatch_status(void*)>> list_calls() {
  static std::size_t number;
  static std::uint64_t bits;
  static std::int64_t tick;
  static double real;
  static const char* text;
  static unlatch_item item;
  static unlatch_array array;
  static const unlatch_event* events;
  static const unlatch_verdict* verdicts;
  static const unlatch_certainty* certainties;
  static const unlatch_finding* findings;
  item.size = sizeof item;
  array.size = sizeof array;
  const auto sim = [](void* handle) { return static_cast<unlatch_simulation*>(handle); };
  const auto batch = [](void* handle) { return static_cast<unlatch_batch*>(handle); };
  return {
      [=](void* h) { return unlatch_count(sim(h), UNLATCH_BODY, &number); },
      [=](void* h) { return unlatch_describe(sim(h), UNLATCH_BODY, 0, &item); },
      [=](void* h) { return unlatch_find(sim(h), UNLATCH_BODY, "core", &number); },
      [=](void* h) { return unlatch_get_mode_name(sim(h), 0, 0, &text); },
      [=](void* h) { return unlatch_get_scenario(sim(h), &text, &real, &real); },
      [=](void* h) { return unlatch_set_channel(sim(h), 0, 0); },
      [=](void* h) { return unlatch_set_channels(sim(h), 0, 1, &real); },
      [=](void* h) { return unlatch_step(sim(h)); },
      [=](void* h) { return unlatch_advance(sim(h), 1, 0, &bits); },
      [=](void* h) { return unlatch_interrupt(h); },
      [=](void* h) { return unlatch_get_tick(sim(h), &tick); },
      [=](void* h) { return unlatch_get_time(sim(h), &real); },
      [=](void* h) { return unlatch_get_hash(sim(h), &bits); },
      [=](void* h) { return unlatch_get_array(sim(h), UNLATCH_POSITIONS, 0, &array); },
      [=](void* h) { return unlatch_get_events(sim(h), &events, &number, &bits); },
      [=](void* h) { return unlatch_judge(sim(h), &verdicts, &number); },
      [=](void* h) { return unlatch_get_certainties(sim(h), &certainties, &number); },
      [=](void* h) { return unlatch_get_findings(sim(h), &findings, &number); },
      [=](void* h) { return unlatch_save(sim(h), nullptr, 0, &number); },
      [=](void* h) { return unlatch_restore(sim(h), &real, sizeof real); },
      [=](void* h) { return unlatch_reset(sim(h)); },
      [=](void* h) { return unlatch_start_recording(sim(h), "/nowhere/x.log"); },
      [=](void* h) { return unlatch_stop_recording(sim(h)); },
      [=](void* h) { return unlatch_close(sim(h)); },
      [=](void* h) { return unlatch_add_sample(batch(h), nullptr, 0); },
      [=](void* h) { return unlatch_run_batch(batch(h), 0, 1); },
      [=](void* h) { return unlatch_get_batch_array(batch(h), UNLATCH_SAMPLE_STATUS, &array); },
      [=](void* h) { return unlatch_get_sample_text(batch(h), 0, &text); },
      [=](void* h) { return unlatch_count_in_batch(batch(h), UNLATCH_BODY, &number); },
      [=](void* h) { return unlatch_describe_in_batch(batch(h), UNLATCH_BODY, 0, &item); },
      [=](void* h) { return unlatch_close_batch(batch(h)); },
  };
}

void expect_refused_by_all(void* handle) {
  int call = 0;
  for (const auto& function : list_calls()) EXPECT_EQ(function(handle), UNLATCH_ERROR_HANDLE) << "call " << call++;
}

TEST(HostileUse, ANullHandleIsRefused) {
  expect_refused_by_all(nullptr);
  ASSERT_EQ(unlatch_step(nullptr), UNLATCH_ERROR_HANDLE);
  EXPECT_THAT(unlatch_get_error(0)->text, HasSubstr("handle"));
}

TEST(HostileUse, AClosedHandleIsRefusedAlsoWhenItsPlaceIsUsedAgain) {
  unlatch_simulation *first = nullptr, *second = nullptr;
  ASSERT_EQ(unlatch_load(kReference, nullptr, &first), UNLATCH_OK);
  ASSERT_EQ(unlatch_close(first), UNLATCH_OK);
  expect_refused_by_all(first);
  ASSERT_EQ(unlatch_load(kReference, nullptr, &second), UNLATCH_OK);
  expect_refused_by_all(first);
  EXPECT_EQ(unlatch_step(second), UNLATCH_OK);
  EXPECT_EQ(unlatch_close(second), UNLATCH_OK);
}

TEST(HostileUse, AForeignPointerIsRefused) {
  int local = 0;
  std::vector<char> heap(64);
  expect_refused_by_all(&local);
  expect_refused_by_all(heap.data());
  expect_refused_by_all(reinterpret_cast<void*>(std::uintptr_t{1}));
  expect_refused_by_all(reinterpret_cast<void*>(~std::uintptr_t{0}));
}

TEST(HostileUse, AHandleOfAnotherKindIsRefused) {
  const Loaded sim(kReference);
  unlatch_batch* batch = nullptr;
  ASSERT_EQ(unlatch_open_batch(kReference, nullptr, &batch), UNLATCH_OK);
  void *simulation = sim.get(), *samples = batch;
  EXPECT_EQ(unlatch_run_batch(static_cast<unlatch_batch*>(simulation), 0, 1), UNLATCH_ERROR_HANDLE);
  EXPECT_EQ(unlatch_close_batch(static_cast<unlatch_batch*>(simulation)), UNLATCH_ERROR_HANDLE);
  EXPECT_EQ(unlatch_step(static_cast<unlatch_simulation*>(samples)), UNLATCH_ERROR_HANDLE);
  EXPECT_EQ(unlatch_close_batch(batch), UNLATCH_OK);
}

TEST(HostileUse, NullArgumentsAreRefused) {
  const Loaded sim(kReference);
  unlatch_simulation* other = nullptr;
  EXPECT_EQ(unlatch_load(nullptr, nullptr, &other), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_load(kReference, nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_load_text(nullptr, 3, "x", nullptr, &other), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_open_recording(nullptr, nullptr, &other), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_count(sim.get(), UNLATCH_BODY, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_describe(sim.get(), UNLATCH_BODY, 0, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_find(sim.get(), UNLATCH_BODY, nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_mode_name(sim.get(), 0, 0, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_set_channels(sim.get(), 0, 1, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_tick(sim.get(), nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_time(sim.get(), nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_hash(sim.get(), nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_array(sim.get(), UNLATCH_POSITIONS, 0, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_events(sim.get(), nullptr, nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_judge(sim.get(), nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_certainties(sim.get(), nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_get_findings(sim.get(), nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_save(sim.get(), nullptr, 100, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_restore(sim.get(), nullptr, 100), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_start_recording(sim.get(), nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_open_batch(nullptr, nullptr, nullptr), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_add_sample(nullptr, nullptr, 2), UNLATCH_ERROR_ARGUMENT);
}

TEST(HostileUse, StructsOfUnknownSizeAndUnknownNumbersAreRefused) {
  const Loaded sim(kReference);
  unlatch_options options{};
  unlatch_simulation* other = nullptr;
  EXPECT_EQ(unlatch_load(kReference, &options, &other), UNLATCH_ERROR_ARGUMENT);
  options.size = sizeof options;
  options.flags = 1u << 17;
  EXPECT_EQ(unlatch_load(kReference, &options, &other), UNLATCH_ERROR_ARGUMENT);
  options.flags = 0;
  options.override_count = 1;
  EXPECT_EQ(unlatch_load(kReference, &options, &other), UNLATCH_ERROR_ARGUMENT);
  options.override_count = 0;
  options.event_capacity = std::numeric_limits<std::uint32_t>::max();
  EXPECT_EQ(unlatch_load(kReference, &options, &other), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(other, nullptr);
  unlatch_item item{};
  EXPECT_EQ(unlatch_describe(sim.get(), UNLATCH_BODY, 0, &item), UNLATCH_ERROR_ARGUMENT);
  unlatch_array array{};
  EXPECT_EQ(unlatch_get_array(sim.get(), UNLATCH_POSITIONS, 0, &array), UNLATCH_ERROR_ARGUMENT);
  array.size = sizeof array;
  EXPECT_EQ(unlatch_get_array(sim.get(), 4711, 0, &array), UNLATCH_ERROR_ARGUMENT);
  std::size_t count = 0;
  for (const std::int32_t kind : {-1, UNLATCH_NUMBER + 1, 4711}) {
    EXPECT_EQ(unlatch_count(sim.get(), kind, &count), UNLATCH_ERROR_ARGUMENT);
  }
  EXPECT_EQ(unlatch_advance(sim.get(), 1, 1u << 9, nullptr), UNLATCH_ERROR_ARGUMENT);
}

// A caller with a shorter struct gets no more than that.
TEST(HostileUse, AShorterStructIsNotWrittenBeyondItsSize) {
  const Loaded sim(kReference);
  struct {
    unlatch_item item;
  } place;
  std::memset(&place, 0x5A, sizeof place);
  place.item.size = offsetof(unlatch_item, first);
  ASSERT_EQ(unlatch_describe(sim.get(), UNLATCH_BODY, 0, &place.item), UNLATCH_OK);
  EXPECT_STREQ(place.item.name, "core");
  EXPECT_EQ(place.item.first, 0x5A5A5A5A);
}

TEST(HostileUse, WhatIsOutOfRangeIsRefusedAndChangesNothing) {
  const Loaded sim(kScenario);
  const std::vector<double> before = sim.get_numbers(UNLATCH_CHANNELS);
  const std::size_t channels = before.size();
  EXPECT_EQ(unlatch_set_channel(sim.get(), channels, 0), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_set_channel(sim.get(), std::numeric_limits<std::size_t>::max(), 0), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_set_channel(sim.get(), 0, std::nan("")), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_set_channel(sim.get(), 0, std::numeric_limits<double>::infinity()), UNLATCH_ERROR_RANGE);
  std::vector<double> values(channels, 0.0);
  values.back() = 1.5;  // one is refused: none is set
  EXPECT_EQ(unlatch_set_channels(sim.get(), 0, channels, values.data()), UNLATCH_ERROR_RANGE);
  EXPECT_THAT(unlatch_get_error(0)->text, HasSubstr("nozzle4"));
  EXPECT_STREQ(unlatch_get_error(0)->key, "channels.nozzle4");
  EXPECT_EQ(unlatch_set_channels(sim.get(), 1, channels, values.data()), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(sim.get_numbers(UNLATCH_CHANNELS), before);
  unlatch_item item{};
  item.size = sizeof item;
  EXPECT_EQ(unlatch_describe(sim.get(), UNLATCH_BODY, 5, &item), UNLATCH_ERROR_RANGE);
  unlatch_array array{};
  array.size = sizeof array;
  EXPECT_EQ(unlatch_get_array(sim.get(), UNLATCH_REACTIONS, 4, &array), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_get_array(sim.get(), UNLATCH_MODAL_COORDINATES, 5, &array), UNLATCH_ERROR_RANGE);
  std::size_t index = 0;
  EXPECT_EQ(unlatch_find(sim.get(), UNLATCH_BODY, "nobody", &index), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_find(sim.get(), UNLATCH_EVENT_KIND, "release", &index), UNLATCH_ERROR_RANGE);  // four have it
  std::size_t needed = 0;
  char small[8];
  EXPECT_EQ(unlatch_save(sim.get(), small, sizeof small, &needed), UNLATCH_ERROR_RANGE);
  EXPECT_GT(needed, sizeof small);
}

TEST(HostileUse, TwoThreadsInOneHandleOneIsRefusedAndNothingBreaks) {
  const Loaded sim(kReference);
  std::atomic<bool> begun{false};
  std::jthread runner([&] {
    begun = true;
    std::uint64_t done = 0;
    // Either thread may be the one that is refused: this one asks again until it is at work.
    unlatch_status status = UNLATCH_ERROR_BUSY;
    while (status == UNLATCH_ERROR_BUSY)
      status = unlatch_advance(sim.get(), std::numeric_limits<std::uint64_t>::max(), 0, &done);
    EXPECT_EQ(status, UNLATCH_INTERRUPTED);
    EXPECT_GT(done, 0u);
  });
  while (!begun) std::this_thread::yield();
  // These calls succeed until the other thread is at work.
  unlatch_status status = UNLATCH_OK;
  while (status == UNLATCH_OK) {
    std::int64_t tick = 0;
    status = unlatch_get_tick(sim.get(), &tick);
  }
  EXPECT_EQ(status, UNLATCH_ERROR_BUSY);
  EXPECT_THAT(unlatch_get_error(0)->text, HasSubstr("another thread"));
  EXPECT_EQ(unlatch_step(sim.get()), UNLATCH_ERROR_BUSY);
  EXPECT_EQ(unlatch_close(sim.get()), UNLATCH_ERROR_BUSY);
  std::int64_t before = 0;
  EXPECT_EQ(unlatch_interrupt(sim.get()), UNLATCH_OK);
  runner.join();
  EXPECT_EQ(unlatch_get_tick(sim.get(), &before), UNLATCH_OK);
  EXPECT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
}

TEST(HostileUse, ThreadsWithHandlesOfTheirOwnGetTheSameBits) {
  std::uint64_t hashes[4] = {};
  {
    std::vector<std::jthread> threads;
    for (std::uint64_t& hash : hashes) {
      threads.emplace_back([&hash] {
        const Loaded sim(kReference);
        EXPECT_EQ(unlatch_advance(sim.get(), 900, 0, nullptr), UNLATCH_OK);
        hash = sim.get_hash();
        EXPECT_EQ(unlatch_step(nullptr), UNLATCH_ERROR_HANDLE);  // errors belong to the thread
        EXPECT_EQ(unlatch_count_errors(), 1u);
      });
    }
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

// --- Errors of scenarios --------------------------------------------------------------------------------------------

constexpr const char* kTwoMistakes = R"(unlatch: 1
name: wrong
step: {dt: 0.001, until: 1}
bodies:
  core:
    mass: -3 kg
    inertia: [1, 1, 1]
  other: {mass: 1, inertia: [1, 1, 1], positon: [1, 0, 0]}
)";

TEST(HostileUse, EveryMistakeOfAScenarioHasFileLineAndKey) {
  const Scratch scratch;
  const std::string path = scratch / "wrong.yaml";
  std::ofstream(path) << kTwoMistakes;
  unlatch_simulation* sim = nullptr;
  for (const bool from_text : {false, true}) {
    const unlatch_status status =
        from_text ? unlatch_load_text(kTwoMistakes, std::strlen(kTwoMistakes), path.c_str(), nullptr, &sim)
                  : unlatch_load(path.c_str(), nullptr, &sim);
    ASSERT_EQ(status, UNLATCH_ERROR_SCENARIO);
    EXPECT_EQ(sim, nullptr);
    ASSERT_EQ(unlatch_count_errors(), 2u);
    EXPECT_EQ(unlatch_get_error(0)->line, 6);
    EXPECT_STREQ(unlatch_get_error(0)->key, "bodies.core.mass");
    EXPECT_STREQ(unlatch_get_error(0)->file, path.c_str());
    EXPECT_EQ(unlatch_get_error(1)->line, 8);
    EXPECT_STREQ(unlatch_get_error(1)->key, "bodies.other.positon");
    EXPECT_THAT(unlatch_get_error(1)->text, HasSubstr("position"));  // did you mean …
    EXPECT_EQ(unlatch_get_error(2), nullptr);
  }
}

TEST(HostileUse, AnOverrideIsNamedAsTheKeyOfItsMistake) {
  const Override wrong("bodies.core.mass=heavy");
  unlatch_simulation* sim = nullptr;
  ASSERT_EQ(unlatch_load(kReference, wrong.get(), &sim), UNLATCH_ERROR_SCENARIO);
  EXPECT_STREQ(unlatch_get_error(0)->key, "bodies.core.mass");
}

TEST(HostileUse, AFileThatIsNoneIsAnError) {
  const Scratch scratch;
  unlatch_simulation* sim = nullptr;
  EXPECT_EQ(unlatch_load((scratch / "no.yaml").c_str(), nullptr, &sim), UNLATCH_ERROR_SCENARIO);
  EXPECT_THAT(unlatch_get_error(0)->text, HasSubstr("no such file"));
  EXPECT_EQ(unlatch_open_recording(kReference, nullptr, &sim), UNLATCH_ERROR_FILE);
  EXPECT_EQ(unlatch_open_recording((scratch / "no.log").c_str(), nullptr, &sim), UNLATCH_ERROR_FILE);
  unlatch_batch* batch = nullptr;
  EXPECT_EQ(unlatch_open_batch((scratch / "no.yaml").c_str(), nullptr, &batch), UNLATCH_ERROR_SCENARIO);
  EXPECT_EQ(batch, nullptr);
  const std::string garbage("\0\xff{{{: [", 9);
  EXPECT_EQ(unlatch_load_text(garbage.data(), garbage.size(), nullptr, nullptr, &sim), UNLATCH_ERROR_SCENARIO);
  EXPECT_EQ(unlatch_load_text("", 0, "empty", nullptr, &sim), UNLATCH_ERROR_SCENARIO);
}

// --- Batches --------------------------------------------------------------------------------------------------------

std::vector<std::int64_t> get_integers(unlatch_batch* batch, std::int32_t which) {
  unlatch_array array{};
  array.size = sizeof array;
  EXPECT_EQ(unlatch_get_batch_array(batch, which, &array), UNLATCH_OK);
  std::vector<std::int64_t> numbers(array.rows);
  std::memcpy(numbers.data(), array.data, array.rows * sizeof(std::int64_t));
  return numbers;
}

TEST(Batches, ASampleHasTheBitsOfASingleRunOnAnyNumberOfThreads) {
  std::vector<std::int64_t> hashes[2];
  for (const std::size_t threads : {1u, 3u}) {
    unlatch_batch* batch = nullptr;
    ASSERT_EQ(unlatch_open_batch(kReference, nullptr, &batch), UNLATCH_OK);
    for (const char* text :
         {"bodies.core.mass=99 t", "bodies.core.mass=100 t", "bodies.core.mass=-1", "bodies.core.mass=101 t"})
      ASSERT_EQ(unlatch_add_sample(batch, &text, 1), UNLATCH_OK);
    ASSERT_EQ(unlatch_run_batch(batch, 0.9, threads), UNLATCH_OK) << unlatch_get_error(0)->text;
    EXPECT_THAT(get_integers(batch, UNLATCH_SAMPLE_STATUS),
                testing::ElementsAre(UNLATCH_OK, UNLATCH_OK, UNLATCH_ERROR_SCENARIO, UNLATCH_OK));
    EXPECT_THAT(get_integers(batch, UNLATCH_SAMPLE_TICKS), testing::ElementsAre(900, 900, 0, 900));
    hashes[threads > 1] = get_integers(batch, UNLATCH_SAMPLE_HASHES);
    const char* text = nullptr;
    ASSERT_EQ(unlatch_get_sample_text(batch, 2, &text), UNLATCH_OK);
    EXPECT_THAT(text, HasSubstr("mass"));
    EXPECT_EQ(unlatch_get_sample_text(batch, 4, &text), UNLATCH_ERROR_RANGE);
    unlatch_array array{};
    array.size = sizeof array;
    EXPECT_EQ(unlatch_get_batch_array(batch, UNLATCH_SAMPLE_MARGINS, &array), UNLATCH_ERROR_ORDER);
    ASSERT_EQ(unlatch_get_batch_array(batch, UNLATCH_SAMPLE_EVENTS, &array), UNLATCH_OK);
    EXPECT_EQ(array.rows, 4u);
    EXPECT_TRUE(std::isnan(unlatch_get_number(&array, 2, 0)));
    EXPECT_EQ(unlatch_close_batch(batch), UNLATCH_OK);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  const Override lightest("bodies.core.mass=99 t");
  const Loaded single(kReference, lightest.get());
  ASSERT_EQ(unlatch_advance(single.get(), 900, 0, nullptr), UNLATCH_OK);
  EXPECT_EQ(static_cast<std::uint64_t>(hashes[0][0]), single.get_hash());
}

TEST(Batches, AnInterruptedBatchGoesOn) {
  unlatch_batch* batch = nullptr;
  ASSERT_EQ(unlatch_open_batch(kReference, nullptr, &batch), UNLATCH_OK);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(unlatch_add_sample(batch, nullptr, 0), UNLATCH_OK);
  ASSERT_EQ(unlatch_interrupt(batch), UNLATCH_OK);
  EXPECT_EQ(unlatch_run_batch(batch, 0.1, 1), UNLATCH_INTERRUPTED);
  EXPECT_THAT(get_integers(batch, UNLATCH_SAMPLE_STATUS), testing::Each(UNLATCH_INTERRUPTED));
  EXPECT_EQ(unlatch_run_batch(batch, 0.1, 2), UNLATCH_OK);
  EXPECT_THAT(get_integers(batch, UNLATCH_SAMPLE_STATUS), testing::Each(UNLATCH_OK));
  EXPECT_EQ(unlatch_run_batch(batch, std::nan(""), 2), UNLATCH_ERROR_RANGE);
  EXPECT_EQ(unlatch_close_batch(batch), UNLATCH_OK);
}

}  // namespace
}  // namespace unlatch::test::hostile_use_test
