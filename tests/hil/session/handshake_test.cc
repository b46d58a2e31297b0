// Answers to Hello: participants that take part, are refused, leave, return.
#include "hil/session/participants/handshake.h"

#include <gtest/gtest.h>

#include "tests/hil/session/fake_connection.h"

namespace unlatch::test::handshake_test {
namespace {

using hil::Reject;
using Standing = hil::Participant::Standing;

hil::HelloMessage make_hello() {
  hil::HelloMessage hello;
  hello.session = 4711;
  hello.schema_hash = hil::kSchemaHash;
  hello.model_hash = 1;
  hello.dt_ns = 1'000'000;
  hello.protocol = hil::kProtocolVersion;
  return hello;
}

class HandshakeTest : public ::testing::Test {
 protected:
  hil::Participants participants_{{"fsw"}};
  hil::Handshake handshake_{make_hello(), participants_};
};

TEST_F(HandshakeTest, ARequiredParticipantJoinsOnce) {
  const auto outcome = handshake_.receive(make_hello_ack(), 0);
  EXPECT_EQ(outcome.notice, hil::kJoined);
  EXPECT_FALSE(outcome.reject);
  EXPECT_TRUE(participants_.is_complete());
  EXPECT_TRUE(handshake_.receive(make_hello_ack(), 0).notice.empty()) << "the same start again";
}

TEST_F(HandshakeTest, AnotherSessionIsCountedAlone) {
  hil::HelloAckMessage answer = make_hello_ack();
  answer.session = 1;
  const auto outcome = handshake_.receive(answer, 0);
  EXPECT_EQ(outcome.reject, Reject::kWrongSession);
  EXPECT_FALSE(outcome.verdict);
  EXPECT_TRUE(outcome.notice.empty());
}

TEST_F(HandshakeTest, ADisagreementIsAReasonNotToStart) {
  hil::HelloAckMessage answer = make_hello_ack();
  answer.model_hash = 2;
  const auto outcome = handshake_.receive(answer, 0);
  EXPECT_EQ(outcome.reject, Reject::kMismatch);
  EXPECT_TRUE(outcome.verdict);
  EXPECT_EQ(outcome.notice, hil::kNotAdmitted);
  EXPECT_EQ(handshake_.get_refusal(), "the flight software 'fsw' does not take part: it expects another model");
  EXPECT_TRUE(handshake_.receive(answer, 0).notice.empty()) << "one notice for each start";
  EXPECT_FALSE(participants_.is_complete());
}

TEST_F(HandshakeTest, ARefusalOfTheParticipantHasItsReason) {
  hil::HelloAckMessage answer = make_hello_ack();
  answer.status = static_cast<std::int32_t>(hil::AckStatus::kRefused);
  hil::set_name(answer.reason, "no channel warp");
  EXPECT_FALSE(handshake_.receive(answer, 0).reject);
  EXPECT_EQ(handshake_.get_refusal(), "the flight software 'fsw' does not take part: no channel warp");
}

TEST_F(HandshakeTest, DuringTheRunARefusalDoesNotCount) {
  handshake_.begin_run();
  hil::HelloAckMessage answer = make_hello_ack();
  answer.dt_ns = 2;
  EXPECT_EQ(handshake_.receive(answer, 0).reject, Reject::kMismatch);
  EXPECT_TRUE(handshake_.get_refusal().empty());
}

// Participant number 0 is an ordinary number.
TEST_F(HandshakeTest, TheSecondOfANameIsRefused) {
  (void)handshake_.receive(make_hello_ack(7), 0);
  const auto outcome = handshake_.receive(make_hello_ack(0), 0);
  EXPECT_EQ(outcome.reject, Reject::kNameTaken);
  EXPECT_EQ(outcome.notice, hil::kSecondOfName);
}

TEST_F(HandshakeTest, LeavingIsPublishedOnce) {
  (void)handshake_.receive(make_hello_ack(), 0);
  hil::HelloAckMessage answer = make_hello_ack();
  answer.status = static_cast<std::int32_t>(hil::AckStatus::kLeaving);
  EXPECT_EQ(handshake_.receive(answer, 0).notice, hil::kLeft);
  EXPECT_TRUE(handshake_.receive(answer, 0).notice.empty());
  EXPECT_TRUE(participants_.find("fsw")->leaving);
}

TEST_F(HandshakeTest, ANewStartOfALostOneTakesItsPlace) {
  (void)handshake_.receive(make_hello_ack(7), 0);
  hil::Participant& participant = *participants_.find("fsw");
  participant.standing = Standing::kLost;
  const auto outcome = handshake_.receive(make_hello_ack(8), -5);
  EXPECT_EQ(outcome.notice, hil::kRejoined);
  EXPECT_EQ(outcome.restarted, &participant);
  EXPECT_EQ(participant.id, 8);
  EXPECT_EQ(participant.waiting_since_ns, -5);
  participant.standing = Standing::kEvicted;
  EXPECT_EQ(handshake_.receive(make_hello_ack(9), 0).reject, Reject::kUnknownParticipant);
}

}  // namespace
}  // namespace unlatch::test::handshake_test
