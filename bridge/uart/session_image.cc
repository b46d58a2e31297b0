#include "bridge/uart/session_image.h"

#include <array>

#include "bridge/udp/udp_packet.h"
#include "hil/session/participants/announcer.h"

namespace unlatch::bridge {
namespace {

void add_frame(const hil::Message& message, std::vector<std::uint8_t>& image) {
  std::array<std::uint8_t, kMaxUdpBytes> frame{};
  const std::size_t length = hil::encode(message, std::span(frame).subspan(kUdpHeaderBytes));
  const std::size_t bytes = seal_udp_message({}, message.kind, frame, length);
  image.insert(image.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(bytes));
}

}  // namespace

std::string find_target_obstacle(const hil::Scenario& scenario) {
  const auto because = [](const std::string& what) { return "a target does without " + what; };
  if (scenario.flight_software.required.size() != 1)
    return because("a bus: name one participant in flight_software.required, the one at the other end of the line");
  if (!scenario.rates.groups.empty() || scenario.rates.states.every != 1)
    return because("rates: every channel, sensor and State is updated at every tick; leave out `rates`");
  if (!scenario.rates.errors.sensors.empty())
    return because("errors of sensors: leave out their `errors`, or add them in the flight software");
  return {};
}

std::vector<std::uint8_t> build_session_image(const hil::Scenario& scenario, const hil::Simulation& simulation,
                                              std::int64_t last_tick) {
  hil::SessionOptions options;
  options.pace = hil::Pace::kLockstep;
  options.last_tick = last_tick;
  options.flight_software = scenario.flight_software;
  options.flight_software.policy = hil::Policy::kPause;  // a target waits
  const std::vector<hil::CatalogMessage> catalog = hil::build_session_catalog(simulation, options);
  std::vector<std::uint8_t> image;
  add_frame(hil::build_hello(simulation, scenario.name, options, catalog), image);
  for (const hil::CatalogMessage& item : catalog) add_frame(item, image);
  return image;
}

}  // namespace unlatch::bridge
