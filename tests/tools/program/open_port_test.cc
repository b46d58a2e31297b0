// Names of transports.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/program/transport.h"

namespace unlatch::test {
namespace {

TEST(OpenPort, AnUnknownTransportIsAnErrorThatListsTheKnownOnes) {
  for (const char* name : {"", "zmq", "DDS", "dds "}) {
    tools::TransportOptions options;
    options.name = name;
    try {
      (void)tools::open_port(options, bridge::Role::kSimulator);
      ADD_FAILURE() << "'" << name << "' opened a port";
    } catch (const bridge::PortError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("dds, lcm, udp or uart:DEVICE,BAUD"));
    }
  }
}

}  // namespace
}  // namespace unlatch::test
