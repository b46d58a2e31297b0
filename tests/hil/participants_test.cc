// The list of participants, and the commands seen from each.
#include "hil/session/participants.h"

#include <gtest/gtest.h>

#include "tests/hil/fake_connection.h"

namespace unlatch::test {
namespace {

using hil::Admission;

TEST(Participants, RequiredOnesCountFromZeroThenGuestsAsTheyCome) {
  hil::Participants participants({"b", "a"});
  EXPECT_EQ(participants.count_missing(), 2);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "guest")), Admission::kFirstStart);
  EXPECT_EQ(participants.admit(make_hello_ack(2, "a")), Admission::kFirstStart);
  EXPECT_EQ(participants.get_index(*participants.find("b")), 0);
  EXPECT_EQ(participants.get_index(*participants.find("a")), 1);
  EXPECT_EQ(participants.get_index(*participants.find("guest")), 2);
  EXPECT_EQ(participants.find(2), participants.find("a"));
  EXPECT_EQ(participants.list_required([](const hil::Participant& p) { return !p.is_present(); }), "'b'");
  EXPECT_FALSE(participants.is_complete());
}

TEST(Participants, ANumberOrNameInUseIsRefused) {
  hil::Participants participants({"a"});
  EXPECT_EQ(participants.admit(make_hello_ack(1, "a")), Admission::kFirstStart);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "a")), Admission::kKnown);
  EXPECT_EQ(participants.admit(make_hello_ack(2, "a")), Admission::kNameTaken);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "b")), Admission::kNameTaken);
}

TEST(Participants, AreSixteenAtMost) {
  hil::Participants participants({});
  for (std::int32_t i = 0; i < 16; ++i) {
    EXPECT_EQ(participants.admit(make_hello_ack(i, ("guest" + std::to_string(i)).c_str())), Admission::kFirstStart);
  }
  EXPECT_EQ(participants.admit(make_hello_ack(16, "one too many")), Admission::kFull);
}

TEST(SeenCommands, AreRecognisedInAnyOrder) {
  hil::SeenCommands seen;
  EXPECT_TRUE(seen.insert(3));
  EXPECT_TRUE(seen.insert(1));
  EXPECT_FALSE(seen.insert(3));
  EXPECT_FALSE(seen.has_all(3, 3));
  EXPECT_TRUE(seen.has_all(3, 1));
  EXPECT_TRUE(seen.insert(2));
  EXPECT_TRUE(seen.has_all(3, 3));
  EXPECT_TRUE(seen.has_all(0, 0));
}

}  // namespace
}  // namespace unlatch::test
