// The codec of hil/session/messages against the classes that lcm-gen generates, and its helpers.
#include <gtest/gtest.h>

#include <cstring>
#include <iostream>
#include <unlatch/Catalog.hpp>
#include <unlatch/Command.hpp>
#include <unlatch/Event.hpp>
#include <unlatch/Health.hpp>
#include <unlatch/Hello.hpp>
#include <unlatch/HelloAck.hpp>
#include <unlatch/Reactions.hpp>
#include <unlatch/Source.hpp>
#include <unlatch/State.hpp>
#include <unlatch/StepAck.hpp>
#include <unlatch/Verdict.hpp>
#include <vector>

#include "tests/bridge/random_messages.h"

namespace unlatch::test {
namespace {

constexpr int kRounds = 500;
constexpr std::uint64_t kSeed = 20240611;

template <class Ours, class Theirs, std::size_t kWireBytes>
struct Pair {
  using Mine = Ours;
  using Lcm = Theirs;
  static constexpr std::size_t kBytes = kWireBytes;
};

template <class P>
class Codec : public testing::Test {
 protected:
  void SetUp() override { std::cout << "seed " << kSeed << '\n'; }
  Random random_{kSeed};
};

using Pairs = testing::Types<
    Pair<hil::HelloMessage, Hello, hil::kHelloWireBytes>, Pair<hil::CatalogMessage, Catalog, hil::kCatalogWireBytes>,
    Pair<hil::HelloAckMessage, HelloAck, hil::kHelloAckWireBytes>, Pair<hil::StateMessage, State, hil::kStateWireBytes>,
    Pair<hil::CommandMessage, Command, hil::kCommandWireBytes>,
    Pair<hil::StepAckMessage, StepAck, hil::kStepAckWireBytes>, Pair<hil::EventMessage, Event, hil::kEventWireBytes>,
    Pair<hil::HealthMessage, Health, hil::kHealthWireBytes>, Pair<hil::VerdictMessage, Verdict, hil::kVerdictWireBytes>,
    Pair<hil::ReactionsMessage, Reactions, hil::kReactionsWireBytes>,
    Pair<hil::SourceMessage, Source, hil::kSourceWireBytes>>;

struct PairName {
  template <class P>
  static std::string GetName(int) {
    return P::Lcm::getTypeName();
  }
};
TYPED_TEST_SUITE(Codec, Pairs, PairName);

TYPED_TEST(Codec, WritesTheBytesOfLcmGen) {
  typename TypeParam::Mine mine;
  typename TypeParam::Lcm theirs;
  static_assert(sizeof mine == sizeof theirs);
  for (int round = 0; round < kRounds; ++round) {
    fill_with_bits(mine, this->random_);
    std::memcpy(static_cast<void*>(&theirs), &mine, sizeof mine);
    std::vector<std::uint8_t> my_bytes(TypeParam::kBytes);
    std::vector<std::uint8_t> their_bytes(static_cast<std::size_t>(theirs.getEncodedSize()));
    ASSERT_EQ(hil::encode(mine, my_bytes), TypeParam::kBytes);
    ASSERT_EQ(theirs.encode(their_bytes.data(), 0, static_cast<int>(their_bytes.size())),
              static_cast<int>(their_bytes.size()));
    ASSERT_EQ(my_bytes, their_bytes) << "round " << round;
  }
}

TYPED_TEST(Codec, ReadsTheBytesOfLcmGen) {
  typename TypeParam::Mine mine;
  typename TypeParam::Mine back;
  typename TypeParam::Lcm theirs;
  for (int round = 0; round < kRounds; ++round) {
    fill_with_bits(mine, this->random_);
    std::memcpy(static_cast<void*>(&theirs), &mine, sizeof mine);
    std::vector<std::uint8_t> bytes(TypeParam::kBytes);
    ASSERT_GT(theirs.encode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
    ASSERT_TRUE(hil::decode(bytes, back));
    ASSERT_EQ(std::memcmp(&back, &mine, sizeof mine), 0) << "round " << round;
  }
}

TYPED_TEST(Codec, RefusesAnotherLengthOrFingerprint) {
  typename TypeParam::Mine mine;
  fill_with_bits(mine, this->random_);
  std::vector<std::uint8_t> bytes(TypeParam::kBytes + 1);
  const std::span all(bytes);
  EXPECT_EQ(hil::encode(mine, all.first(TypeParam::kBytes - 1)), 0U);
  ASSERT_EQ(hil::encode(mine, all), TypeParam::kBytes);

  typename TypeParam::Mine back{};
  const auto untouched = back;
  EXPECT_FALSE(hil::decode(all.first(0), back));
  EXPECT_FALSE(hil::decode(all.first(TypeParam::kBytes - 1), back));
  EXPECT_FALSE(hil::decode(all, back));
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[i] ^= 0x10U;
    EXPECT_FALSE(hil::decode(all.first(TypeParam::kBytes), back)) << "fingerprint byte " << i;
    bytes[i] ^= 0x10U;
  }
  EXPECT_EQ(std::memcmp(&back, &untouched, sizeof back), 0);
  EXPECT_TRUE(hil::decode(all.first(TypeParam::kBytes), back));
}

TEST(Messages, EveryKindSurvivesTheCodec) {
  std::cout << "seed " << kSeed << '\n';
  Random random(kSeed);
  for (const hil::MessageKind kind : list_kinds()) {
    const hil::Message message = make_random_message(kind, random);
    EXPECT_TRUE(hil::is_well_formed(message)) << hil::get_kind_name(kind);
    std::array<std::uint8_t, hil::kMaxWireBytes> bytes{};
    const std::size_t length = hil::encode(message, bytes);
    ASSERT_EQ(length, 8 + hil::get_size(kind));
    hil::Message back;
    ASSERT_TRUE(hil::decode(kind, std::span(bytes).first(length), back));
    EXPECT_TRUE(is_same(back, message)) << hil::get_kind_name(kind);
  }
}

TEST(Messages, ChannelsNameTheirKind) {
  for (const hil::MessageKind kind : list_kinds()) {
    hil::MessageKind found{};
    ASSERT_TRUE(hil::find_kind(hil::get_channel(kind), found));
    EXPECT_EQ(found, kind);
  }
  hil::MessageKind found{};
  EXPECT_FALSE(hil::find_kind("UNLATCH_", found));
  EXPECT_EQ(hil::get_size(static_cast<hil::MessageKind>(99)), 0U);
}

TEST(Messages, CountsOutOfRangeAreNotWellFormed) {
  hil::StateMessage state{};
  state.parts = 1;
  EXPECT_TRUE(hil::is_well_formed(state));
  state.body_count = static_cast<std::int32_t>(hil::kBodiesPerPart);
  EXPECT_TRUE(hil::is_well_formed(state));
  state.body_count += 1;
  EXPECT_FALSE(hil::is_well_formed(state));
  state.body_count = -1;
  EXPECT_FALSE(hil::is_well_formed(state));
  hil::HelloMessage hello{};
  hello.pace = 3;
  EXPECT_FALSE(hil::is_well_formed(hello));
}

TEST(Names, AreCutBetweenCharactersAndFilledWithNul) {
  std::array<std::uint8_t, 6> octets{};
  octets.fill(0xFF);
  hil::set_name(octets, "ab");
  EXPECT_EQ(hil::get_name(octets), "ab");
  EXPECT_EQ(octets.back(), 0);
  hil::set_name(octets, "abcdefgh");
  EXPECT_EQ(hil::get_name(octets), "abcde");
  hil::set_name(octets, "abc\u043a\u043e");  // the second Cyrillic letter would not fit completely
  EXPECT_EQ(hil::get_name(octets), "abc\u043a");
  octets.fill('x');  // no NUL, as from a careless sender
  EXPECT_EQ(hil::get_name(octets), "xxxxxx");
  hil::set_name(std::span<std::uint8_t>(), "a");
}

}  // namespace
}  // namespace unlatch::test
