// Writes the initial inputs that are not text, from the present code, so that they never become outdated:
//   make_seeds FOLDER     FOLDER/<target>; empty for targets whose inputs are text, in corpus/
#include <atomic>
#include <filesystem>
#include <fstream>

#include "bridge/udp/udp_packet.h"
#include "hil/run/checkpoint.h"
#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/flexible/modes_file.h"
#include "library/fmi/zip.h"
#include "tests/bridge/random_messages.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kSeed = 9;

void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

template <class T>
std::string to_bytes(const T& value, std::size_t size = sizeof(T)) {
  return {reinterpret_cast<const char*>(&value), size};
}

// Writes each message in the forms of LCM and DDS.
void write_messages(const fs::path& folder) {
  test::Random random(kSeed);
  for (const hil::MessageKind kind : test::list_kinds()) {
    const hil::Message message = test::make_random_message(kind, random);
    const std::string name(hil::get_kind_name(kind)), choice(1, static_cast<char>(kind));
    std::array<std::uint8_t, hil::kMaxWireBytes> wire{};
    const std::size_t length = hil::encode(message, wire);
    write(folder / "messages" / name, choice + to_bytes(wire, length));
    const std::string little_endian("\0\1\0\0", 4);
    write(folder / "dds" / name, choice + little_endian + to_bytes(message.hello, hil::get_size(kind)));
  }
}

// Big-endian number, as in LCM.
std::string to_big_endian(std::uint64_t number, std::size_t length) {
  std::string bytes;
  for (std::size_t i = length; i-- > 0;) bytes += static_cast<char>(number >> 8 * i & 0xFF);
  return bytes;
}

// Writes each message in one datagram, then in fragments of macOS's size and of a few bytes; lcm_fuzz.cc explains the
// marks.
void write_datagrams(const fs::path& folder) {
  test::Random random(kSeed);
  for (const hil::MessageKind kind : test::list_kinds()) {
    const std::string name(hil::get_kind_name(kind)), channel = std::string(hil::get_channel(kind)) + '\0';
    std::array<std::uint8_t, hil::kMaxWireBytes> wire{};
    const std::size_t length = hil::encode(test::make_random_message(kind, random), wire);
    const std::string bytes = to_bytes(wire, length);
    std::string all;
    const auto add = [&all](const std::string& datagram) {
      const auto size = static_cast<std::uint16_t>(datagram.size());
      all += '\7' + to_bytes(size) + datagram;
    };
    add(to_big_endian(0x4c433032, 4) + to_big_endian(1, 4) + channel + bytes);
    write(folder / (name + "-short"), all);
    for (const std::size_t part : {std::size_t{1423}, length / 5 + 1}) {
      all.clear();
      const std::size_t count = (length + part - 1) / part;
      for (std::size_t i = 0; i < count; ++i) {
        add(to_big_endian(0x4c433033, 4) + to_big_endian(2, 4) + to_big_endian(length, 4) + to_big_endian(i * part, 4) +
            to_big_endian(i, 2) + to_big_endian(count, 2) + (i == 0 ? channel : "") + bytes.substr(i * part, part));
      }
      write(folder / (name + "-" + std::to_string(part)), all);
    }
  }
}

// Writes each message in the form of the UDP transport, after a join.
void write_udp(const fs::path& folder) {
  test::Random random(kSeed);
  for (const hil::MessageKind kind : test::list_kinds()) {
    std::array<std::uint8_t, bridge::kMaxUdpBytes> datagram{};
    std::string all;
    const auto add = [&](std::size_t size) {
      all += to_bytes(static_cast<std::uint16_t>(size)) + to_bytes(datagram, size);
    };
    add(bridge::build_udp_join({.run = 1, .sequence = 0}, bridge::Role::kParticipant, datagram));
    const std::size_t length =
        hil::encode(test::make_random_message(kind, random), std::span(datagram).subspan(bridge::kUdpHeaderBytes));
    add(bridge::seal_udp_message({.run = 1, .sequence = 1}, kind, datagram, length));
    write(folder / std::string(hil::get_kind_name(kind)), all);
  }
}

// Writes two messages of each kind as frames of a serial line, noise between them, in pieces.
void write_uart(const fs::path& folder) {
  test::Random random(kSeed);
  for (const hil::MessageKind kind : test::list_kinds()) {
    std::string stream = "noise UNL1";
    for (std::uint32_t i = 0; i < 2; ++i) {
      std::array<std::uint8_t, bridge::kMaxUdpBytes> frame{};
      const std::size_t length =
          hil::encode(test::make_random_message(kind, random), std::span(frame).subspan(bridge::kUdpHeaderBytes));
      stream += to_bytes(frame, bridge::seal_udp_message({.run = 1, .sequence = i}, kind, frame, length));
    }
    constexpr std::size_t kPiece = 200;
    std::string all;
    for (std::size_t at = 0; at < stream.size(); at += kPiece) {
      const std::string piece = stream.substr(at, kPiece);
      all += static_cast<char>(piece.size()) + piece;
    }
    write(folder / std::string(hil::get_kind_name(kind)), all);
  }
}

// Writes a recording of the small scenario, its first half, and checkpoints.
void write_logs(const fs::path& folder) {
  const hil::Scenario scenario = hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml");
  const auto simulation = hil::build_simulation(scenario);
  constexpr std::int64_t kLast = 4;
  hil::write_checkpoint(folder / "checkpoint" / "begin", scenario, *simulation, kLast);
  const hil::LogHeader header = hil::build_log_header(scenario, *simulation, hil::Pace::kFast, 1, kLast);
  hil::RunAnalysis analysis(scenario, *simulation);
  {
    hil::Recorder recorder(folder / "log" / "whole", header);
    const std::atomic<bool> stop{false};
    hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, kLast, stop, [] {});
    recorder.close(end);
  }
  hil::write_checkpoint(folder / "checkpoint" / "end", scenario, *simulation, kLast);
  fs::copy_file(folder / "log" / "whole", folder / "log" / "half");
  fs::resize_file(folder / "log" / "half", fs::file_size(folder / "log" / "whole") * 2 / 3);
}

// Writes a command, an acknowledgement, other simulators and a farewell, under every pace and policy; and another
// simulator at the start. session_fuzz.cc explains the marks.
void write_sessions(const fs::path& folder) {
  hil::CommandMessage command;
  command.sequence = 1;
  command.valid_until_tick = -1;
  command.value = 0.75;
  hil::StepAckMessage ack;
  ack.last_command = 1;
  ack.command_count = 1;
  hil::HelloAckMessage farewell;
  farewell.status = static_cast<std::int32_t>(hil::AckStatus::kLeaving);
  hil::HelloMessage other;
  other.session = 12;
  const std::string hello = to_bytes(other);
  const std::string said = '\x72' + to_bytes(command) + '\x08' + hello + '\x4a' + hello + '\x70' + to_bytes(ack) +
                           '\x80' + '\x41' + to_bytes(farewell);
  for (int choice = 0; choice < 2 * static_cast<int>(hil::kPolicyNames.size()); ++choice)
    write(folder / "session" / std::to_string(choice), static_cast<char>(choice) + said);
  write(folder / "session" / "other", '\0' + ('\x08' + hello));
  write(folder / "session" / "namesake", '\0' + ('\x4a' + hello));
}

// Writes six masses on three crossed bars; one mode, in which the first bar stretches.
void write_modes(const fs::path& folder) {
  hil::Modes modes;
  modes.title = "Crossed bars";
  modes.frequencies_hz = Eigen::VectorXd::Constant(1, 3.5);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d place = side * Eigen::Vector3d::Unit(axis);
      modes.points.push_back(
          {1, place, axis == 0 ? Eigen::Matrix3Xd(std::sqrt(0.5) * place) : Eigen::Matrix3Xd::Zero(3, 1)});
    }
  modes.markers.push_back({"end", Eigen::Vector3d::UnitX(), modes.points[1].shape, Eigen::Matrix3Xd::Zero(3, 1)});
  hil::FlexibleReport report;
  (void)hil::build_flexible_body(modes, {}, report);  // it is a valid flexible body
  write(folder / "modes" / "bars", hil::write_modes_text(modes));
}

// Writes descriptions of both versions, alone and in zip files.
void write_fmus(const fs::path& folder) {
  const std::string variables = R"(<ModelVariables>)"
                                R"(<Float64 name="time" valueReference="0" causality="independent"/>)"
                                R"(<Float64 name="core.gyro.x" valueReference="1" causality="input" start="0"/>)"
                                R"(<Boolean name="go" valueReference="2" causality="output"/>)"
                                R"(<Float64 name="many" valueReference="3"><Dimension start="3"/></Float64>)"
                                R"(</ModelVariables>)";
  const std::string three = R"(<?xml version="1.0"?><fmiModelDescription fmiVersion="3.0" modelName="a" )"
                            R"(instantiationToken="{1}"><CoSimulation modelIdentifier="a"/>)" +
                            variables + R"(<ModelStructure/></fmiModelDescription>)";
  const std::string two = R"(<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="a" guid="{1}">)"
                          R"(<CoSimulation modelIdentifier="a"/><ModelVariables>)"
                          R"(<ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/>)"
                          R"(</ScalarVariable></ModelVariables></fmiModelDescription>)";
  for (const auto& [name, text] : {std::pair{"three", &three}, {"two", &two}}) {
    write(folder / (std::string(name) + ".xml"), "\x01" + *text);
    fmi::Zip zip;
    zip.add("modelDescription.xml", *text);
    zip.add("binaries/x86_64-linux/a.so", "no binary");
    write(folder / (std::string(name) + ".fmu"), std::string(1, '\0') + zip.finish());
  }
}

void write_plan_image(const fs::path& folder) {
  const auto simulation = hil::build_simulation(hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml"));
  const std::span<const std::byte> image = simulation->plan().get_image();
  write(folder / "small", {reinterpret_cast<const char*>(image.data()), image.size()});
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "make_seeds FOLDER\n");
    return 2;
  }
  const fs::path folder(arguments[1]);
  for (const char* target :
       {"messages", "dds", "log", "checkpoint", "session", "scenario", "override", "faults", "modes", "csv",
        "expression", "calculix", "lcm", "udp", "uart", "campaign", "requirements", "fmu", "plan_image"}) {
    fs::remove_all(folder / target);
    fs::create_directories(folder / target);
  }
  write_messages(folder);
  write_datagrams(folder / "lcm");
  write_udp(folder / "udp");
  write_uart(folder / "uart");
  write_logs(folder);
  write_sessions(folder);
  write_modes(folder);
  write_fmus(folder / "fmu");
  write_plan_image(folder / "plan_image");
  return 0;
}
