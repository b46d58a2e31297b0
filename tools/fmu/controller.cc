#include "tools/fmu/controller.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "tools/fmu/co_simulation.h"
#include "tools/fmu/description.h"
#include "tools/fmu/zip_file.h"

namespace unlatch::fmu {
namespace {

namespace fs = std::filesystem;
using fsw::ControlError;
using fsw::Vehicle;

// A folder that is gone with this.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string made = (fs::temp_directory_path() / "unlatch-fmu-XXXXXX").string();
    if (mkdtemp(made.data()) == nullptr) throw FmuError("no temporary folder can be made at " + made);
    path_ = made;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string read_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (size > ZipFile::kMostBytes) throw FmuError("it is larger than 1 GiB");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (!file || size == 0) throw FmuError("it cannot be read, or is empty");
  return bytes.str();
}

std::string get_platform(int version) {
#if defined(__aarch64__)
  return version == 3 ? "aarch64-linux" : "linux-aarch64";
#else
  return version == 3 ? "x86_64-linux" : "linux64";
#endif
}

void unpack(const ZipFile& zip, const std::string& member, const fs::path& folder) {
  const fs::path path = folder / member;
  fs::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file << zip.read(member);
  if (!file.flush()) throw FmuError(member + ": it cannot be unpacked to " + path.string());
}

// The binary's member; throws with the platforms that there are.
std::string find_binary(const ZipFile& zip, const Description& description) {
  const std::string platform = get_platform(description.version);
  const std::string wanted = "binaries/" + platform + "/" + description.identifier + ".so";
  if (zip.members().contains(wanted)) return wanted;
  std::set<std::string> others;
  for (const auto& [name, member] : zip.members()) {
    const std::size_t slash = name.find('/', 9);
    if (name.starts_with("binaries/") && slash != std::string::npos) others.insert(name.substr(9, slash - 9));
  }
  std::string list;
  for (const std::string& other : others) list += (list.empty() ? "" : ", ") + other;
  throw FmuError("it has no " + wanted + "; it has binaries for: " + (list.empty() ? "nothing" : list));
}

// "sensors.gyro.x" without "sensors.", the first of these prefixes that it has.
std::string strip(const std::string& name, std::initializer_list<const char*> prefixes) {
  for (const std::string prefix : prefixes)
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  return name;
}

struct StatePart {
  const char* name;
  double hil::BodyStateMessage::*member;
};
using Body = hil::BodyStateMessage;
constexpr StatePart kStateParts[] = {
    {"position.x", &Body::x},          {"position.y", &Body::y},          {"position.z", &Body::z},
    {"attitude.w", &Body::qw},         {"attitude.x", &Body::qx},         {"attitude.y", &Body::qy},
    {"attitude.z", &Body::qz},         {"velocity.x", &Body::vx},         {"velocity.y", &Body::vy},
    {"velocity.z", &Body::vz},         {"angular_velocity.x", &Body::wx}, {"angular_velocity.y", &Body::wy},
    {"angular_velocity.z", &Body::wz},
};

class Controller final : public fsw::ControlLaw {
 public:
  Controller(const std::string& path, const NameMap& names) : file_(fs::path(path).filename().string()), names_(names) {
    call([&] {
      const ZipFile zip(read_file(path));
      description_ = read_description(zip.read("modelDescription.xml"));
      check_names();
      binary_ = find_binary(zip, description_);
      for (const auto& [name, member] : zip.members())
        if (name.starts_with("resources/") || name.starts_with(binary_.substr(0, binary_.rfind('/') + 1)))
          unpack(zip, name, folder_.path());
      fs::create_directories(folder_.path() / "resources");
      load();
    });
  }

  std::string attach(const Vehicle& vehicle) override {
    std::string missing;
    inputs_.clear();
    outputs_.clear();
    for (const Variable& variable : description_.variables) {
      if (variable.causality == Variable::Causality::kInput) {
        const std::string name = get_name(variable);
        if (name == kUnconnected) continue;
        std::optional<Input> input = find_input(variable, name, vehicle);
        if (input) inputs_.push_back(std::move(*input));
        if (!input)
          missing += (missing.empty() ? "" : ", ") + ("input '" + variable.name) + "'" +
                     (name == variable.name ? "" : ", mapped to '" + name + "'") +
                     ", which is no sensor and no state (--map gives it another name)";
      } else if (variable.causality == Variable::Causality::kOutput) {
        const std::string name = get_name(variable);
        const std::string short_name = strip(name, {"channels.", "channel."});
        const int channel = vehicle.find_channel(short_name);
        const auto same = std::ranges::find(outputs_, channel, &Output::channel);
        if (channel >= 0 && same != outputs_.end())
          missing += (missing.empty() ? "" : ", ") + ("a channel of its own for output '" + variable.name) +
                     "': it is mapped to '" + name + "', as is '" + same->variable->name + "'";
        if (channel >= 0) outputs_.push_back({&variable, channel, std::nullopt});
        const bool is_meant = names_.contains(variable.name) || short_name != name;
        if (channel < 0 && is_meant && name != kUnconnected)
          missing += (missing.empty() ? "" : ", ") + ("output '" + variable.name) + "', " +
                     (name == variable.name ? "" : "mapped to '" + name + "', ") + "which is no channel";
      }
    }
    for (const auto* variable : list_used())
      if (variable->kind == Variable::Kind::kOther || variable->array)
        missing += (missing.empty() ? "" : ", ") + ("'" + variable->name) +
                   "' as a scalar of type Real (Float64) or Boolean, the types that can be mapped";
    for (const auto* variable : list_used())
      if (!variable->unit.empty() &&
          std::ranges::find(description_.scaled_units, variable->unit) != description_.scaled_units.end())
        missing += (missing.empty() ? "" : ", ") + ("'" + variable->name) + "' in SI: it is in '" + variable->unit +
                   "', and values are not converted";
    if (outputs_.empty())
      missing += (missing.empty() ? "" : ", ") + std::string("an output that is called as a channel");
    if (!missing.empty()) return "for FMU " + file_ + ": " + missing;
    call([&] { load(); });
    time_ns_ = -1;
    return {};
  }

  void update(std::int64_t time_ns, const Vehicle& vehicle, fsw::Commands& commands) override {
    call(
        [&] {
          const double time = static_cast<double>(time_ns) * 1e-9;
          if (time_ns_ < 0) simulation_->enter_initialization(time);
          for (const Input& input : inputs_) simulation_->set(*input.variable, input.read(vehicle));
          if (time_ns_ < 0) {
            simulation_->exit_initialization();
          } else {
            const double begin = static_cast<double>(time_ns_) * 1e-9;
            simulation_->step(begin, static_cast<double>(time_ns - time_ns_) * 1e-9);
          }
          if (const std::string warning = simulation_->take_warning(); !warning.empty() && !warned_) {
            warned_ = true;
            std::fprintf(stderr, "FMU %s at t = %.9g s: %s; further warnings of it are not shown\n", file_.c_str(),
                         time, warning.c_str());
          }
          time_ns_ = time_ns;
          for (Output& output : outputs_) {
            const double value = simulation_->get(*output.variable);
            if (!std::isfinite(value))
              throw FmuError("output '" + output.variable->name + "' is " + (std::isnan(value) ? "NaN" : "infinite"));
            if (output.sent != value) commands.set(output.channel, value);
            output.sent = value;
          }
        },
        time_ns);
  }

 private:
  struct Input {
    const Variable* variable;
    std::function<double(const Vehicle&)> read;
  };
  struct Output {
    const Variable* variable;
    int channel;
    std::optional<double> sent;
  };

  static constexpr const char* kUnconnected = "-";

  // Its name in the scenario.
  [[nodiscard]] std::string get_name(const Variable& variable) const {
    const auto mapped = names_.find(variable.name);
    return mapped == names_.end() ? variable.name : mapped->second;
  }

  void check_names() const {
    for (const auto& [name, to] : names_) {
      const bool known = std::ranges::any_of(description_.variables, [&name = name](const Variable& variable) {
        return variable.name == name && variable.causality != Variable::Causality::kOther;
      });
      if (known) continue;
      std::string list;
      for (const Variable& variable : description_.variables)
        if (variable.causality != Variable::Causality::kOther) list += (list.empty() ? "" : ", ") + variable.name;
      throw FmuError("it has no input or output '" + name + "', which is mapped to '" + to +
                     "'; it has: " + (list.empty() ? "none" : list));
    }
  }

  template <class Function>
  void call(const Function& function, std::optional<std::int64_t> time_ns = std::nullopt) {
    try {
      function();
    } catch (const std::exception& error) {  // of files too
      char at[48] = "";
      if (time_ns) std::snprintf(at, sizeof at, " at t = %.9g s", static_cast<double>(*time_ns) * 1e-9);
      throw ControlError("FMU " + file_ + at + ": " + error.what());
    }
  }

  void load() {
    simulation_.reset();
    const auto load_version = description_.version == 3 ? &load_fmi3 : &load_fmi2;
    simulation_ =
        load_version(description_, (folder_.path() / binary_).string(), (folder_.path() / "resources").string());
  }

  static std::optional<Input> find_input(const Variable& variable, const std::string& called, const Vehicle& vehicle) {
    const int sensor = vehicle.find_sensor(strip(called, {"sensors.", "sensor.", "received."}));
    if (sensor >= 0) return Input{&variable, [sensor](const Vehicle& v) { return v.get_sensor(sensor); }};
    const std::string name = strip(called, {"bodies."});
    for (const StatePart& part : kStateParts) {
      const std::string ending = std::string(".") + part.name;
      if (!name.ends_with(ending)) continue;
      const int body = vehicle.find_body(name.substr(0, name.size() - ending.size()));
      if (body < 0) continue;
      return Input{&variable, [body, member = part.member](const Vehicle& v) { return v.get_body(body).*member; }};
    }
    return std::nullopt;
  }

  [[nodiscard]] std::vector<const Variable*> list_used() const {
    std::vector<const Variable*> used;
    for (const Input& input : inputs_) used.push_back(input.variable);
    for (const Output& output : outputs_) used.push_back(output.variable);
    return used;
  }

  const std::string file_;
  const NameMap names_;
  TemporaryFolder folder_;
  Description description_;
  std::string binary_;  // member
  std::unique_ptr<CoSimulation> simulation_;
  std::vector<Input> inputs_;
  std::vector<Output> outputs_;
  bool warned_ = false;        // a warning of the FMU was printed
  std::int64_t time_ns_ = -1;  // up to which it has come; −1: not initialized
};

}  // namespace

std::unique_ptr<fsw::ControlLaw> open_controller(const std::string& path, const NameMap& names) {
  try {
    return std::make_unique<Controller>(path, names);
  } catch (const FmuError& error) {  // no temporary folder
    throw ControlError(error.what());
  }
}

}  // namespace unlatch::fmu

// Entry point of the module unlatch-controller.
extern "C" unlatch::fsw::ControlLaw* unlatch_open_controller(const char* path, const unlatch::fmu::NameMap& names) {
  return unlatch::fmu::open_controller(path, names).release();
}
