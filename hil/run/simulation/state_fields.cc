#include "hil/run/simulation/state_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <span>

#include "hil/run/simulation/model_messages.h"

namespace unlatch::hil {
namespace {

constexpr const char* kHeaderFields[] = {"tick", "plan_hash"};
constexpr const char* kBodyFields[] = {"p.x", "p.y", "p.z", "q.w", "q.x", "q.y", "q.z",
                                       "v.x", "v.y", "v.z", "w.x", "w.y", "w.z"};
constexpr const char* kJointFields[] = {"mode",     "angle.x",  "angle.y",  "angle.z",  "offset.x", "offset.y",
                                        "offset.z", "locked.w", "locked.x", "locked.y", "locked.z"};
constexpr const char* kElementFields[] = {"switched_on", "from", "to", "start", "duration"};
constexpr const char* kEventFields[] = {"phase", "due"};
constexpr const char* kSignalFields[] = {"value"};
constexpr const char* kAuxiliaryFields[] = {"value"};
constexpr const char* kContactFields[] = {"closed", "edge"};
constexpr const char* kEngagedFields[] = {"engaged"};
constexpr const char* kBearingFields[] = {"bearing"};
constexpr const char* kRigidFields[] = {"force"};
constexpr const char* kSlipFields[] = {"slip.x", "slip.y", "slip.z"};
constexpr const char* kFrictionFields[] = {"friction.x", "friction.y", "friction.z"};

// Auxiliary states, in the order of State::auxiliary.
std::vector<std::string> list_auxiliary(const Model& model) {
  std::vector<std::string> names;
  for (const Body& body : model.bodies)
    if (body.law) names.push_back("body '" + body.name + "' burnt");
  for (const Body& body : model.bodies) {
    if (!body.flexible) continue;
    for (const char* what : {" mode ", " rate of mode "})
      for (Eigen::Index k = 1; k <= body.flexible->frequencies.size(); ++k)
        names.push_back("body '" + body.name + "'" + what + std::to_string(k));
  }
  for (const Contact& contact : model.contacts)
    for (const char* what : {" impulse", " slip", " dissipated"})
      names.push_back("contact '" + contact.name + "'" + what);
  return names;
}

// Cords with drums, in the order of State::bearings.
std::vector<std::string> list_wound_cords(const Model& model) {
  std::vector<std::string> names;
  for (const OneSided& cord : model.one_sided)
    if (cord.drum) names.push_back(cord.name);
  return names;
}

// Items of one kind, one after the other in the block: each has the same fields of 8 bytes.
struct Section {
  const std::byte* begin;
  std::size_t count;
  std::span<const char* const> fields;
  std::size_t integers;  // number of integer fields, the first ones
  std::function<std::string(std::size_t)> name;
};

template <class T, std::size_t N>
Section make_section(std::span<T> items, const char* const (&fields)[N], std::size_t integers,
                     std::function<std::string(std::size_t)> name) {
  static_assert(sizeof(T) == 8 * N);
  return {reinterpret_cast<const std::byte*>(items.data()), items.size(), fields, integers, std::move(name)};
}

std::string quote(const char* kind, const std::string& name) { return std::string(kind) + " '" + name + "'"; }

std::vector<Section> build_sections(const Model& model, const State& state) {
  const auto event_name = [&model](std::size_t i) {
    const Event& event = model.events[i];
    return quote("event", event.subject.empty() ? event.name : event.name + " " + event.subject);
  };
  const auto rigid_name = [](std::size_t i) { return "pair " + std::to_string(i + 1) + " of shapes in rigid contact"; };
  return {
      make_section(std::span(state.header, 1), kHeaderFields, 2, [](std::size_t) { return "state"; }),
      make_section(state.bodies, kBodyFields, 0, [&](std::size_t i) { return quote("body", model.bodies[i].name); }),
      make_section(state.joints, kJointFields, 1, [&](std::size_t i) { return quote("joint", model.joints[i].name); }),
      make_section(state.elements, kElementFields, 0,
                   [&](std::size_t i) { return quote("element", model.element_name(static_cast<int>(i))); }),
      make_section(state.events, kEventFields, 1, event_name),
      make_section(state.signals, kSignalFields, 0, [&](std::size_t i) { return quote("signal", model.signals[i]); }),
      make_section(state.auxiliary, kAuxiliaryFields, 0,
                   [names = list_auxiliary(model)](std::size_t i) { return names[i]; }),
      make_section(state.contacts, kContactFields, 1,
                   [](std::size_t i) { return "pair " + std::to_string(i + 1) + " of shapes in contact"; }),
      make_section(state.engaged, kEngagedFields, 1,
                   [&](std::size_t i) { return quote("element", model.one_sided[i].name); }),
      make_section(state.bearings, kBearingFields, 0,
                   [names = list_wound_cords(model)](std::size_t i) { return quote("element", names[i]); }),
      make_section(state.rigid_forces, kRigidFields, 0, rigid_name),
      make_section(state.rigid_slips, kSlipFields, 0, rigid_name),
      make_section(state.rigid_frictions, kFrictionFields, 0, rigid_name),
  };
}

// Word of the block, `offset` bytes from its beginning, with the name of its field.
FieldDifference name_word(const std::vector<Section>& sections, const std::byte* block, std::size_t offset) {
  for (const Section& section : sections) {
    const std::size_t width = section.fields.size();
    const auto word = static_cast<std::size_t>(block + offset - section.begin) / 8;
    if (block + offset < section.begin || word >= section.count * width) continue;
    return {section.name(word / width), section.fields[word % width], word % width >= section.integers};
  }
  return {"state", "word " + std::to_string(offset / 8)};  // a kind without names here
}

std::uint64_t get_word(const std::byte* from) {
  std::uint64_t word;
  std::memcpy(&word, from, sizeof word);
  return word;
}

void compare(const std::string& of, const char* field, double a, double b, std::vector<FieldDifference>& to) {
  const auto bits_a = std::bit_cast<std::uint64_t>(a), bits_b = std::bit_cast<std::uint64_t>(b);
  if (bits_a != bits_b) to.push_back({of, field, true, bits_a, bits_b});
}

}  // namespace

// Doubles of one sign are ordered as their bits are; both zeros are 0.
std::optional<std::uint64_t> FieldDifference::calc_ulps() const {
  if (!real || std::isnan(get_a()) || std::isnan(get_b())) return std::nullopt;
  const auto place = [](std::uint64_t bits) {
    const auto size = static_cast<std::int64_t>(bits & ~(std::uint64_t{1} << 63));
    return bits >> 63 != 0 ? -size : size;
  };
  const std::int64_t low = std::min(place(a), place(b)), high = std::max(place(a), place(b));
  return static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
}

std::vector<FieldDifference> compare_states(const Model& model, const State& a, const State& b) {
  std::vector<FieldDifference> differences;
  const std::vector<Section> sections = build_sections(model, a);
  const std::byte *const block_a = a.get_bytes().data(), *const block_b = b.get_bytes().data();
  for (std::size_t offset = 0; offset < a.get_bytes().size(); offset += 8) {
    const std::uint64_t bits_a = get_word(block_a + offset), bits_b = get_word(block_b + offset);
    if (bits_a == bits_b) continue;
    FieldDifference& difference = differences.emplace_back(name_word(sections, block_a, offset));
    difference.a = bits_a;
    difference.b = bits_b;
  }
  return differences;
}

std::vector<FieldDifference> compare_states(const Model& model, const StateMessage& a, const StateMessage& b) {
  std::vector<FieldDifference> differences;
  const std::size_t first = static_cast<std::size_t>(a.part);
  const auto bodies = static_cast<std::size_t>(std::min(a.body_count, b.body_count));
  for (std::size_t i = 0; i < bodies && first * kBodiesPerPart + i < model.bodies.size(); ++i) {
    const std::string of = quote("body", model.bodies[first * kBodiesPerPart + i].name);
    const BodyStateMessage &x = a.bodies[i], &y = b.bodies[i];
    const double of_a[] = {x.x, x.y, x.z, x.qw, x.qx, x.qy, x.qz, x.vx, x.vy, x.vz, x.wx, x.wy, x.wz};
    const double of_b[] = {y.x, y.y, y.z, y.qw, y.qx, y.qy, y.qz, y.vx, y.vy, y.vz, y.wx, y.wy, y.wz};
    for (std::size_t k = 0; k < std::size(of_a); ++k) compare(of, kBodyFields[k], of_a[k], of_b[k], differences);
  }
  const auto joints = static_cast<std::size_t>(std::min(a.joint_count, b.joint_count));
  for (std::size_t i = 0; i < joints && first * kJointsPerPart + i < model.joints.size(); ++i) {
    if (a.modes[i] == b.modes[i]) continue;
    const std::string of = quote("joint", model.joints[first * kJointsPerPart + i].name);
    differences.push_back({of, "mode", false, a.modes[i], b.modes[i]});
  }
  for (const CatalogMessage& item : build_catalog(model)) {
    if (item.kind != static_cast<std::int32_t>(CatalogKind::kSensor)) continue;
    const std::size_t i = static_cast<std::size_t>(item.index) - first * kSensorsPerPart;
    if (i >= static_cast<std::size_t>(std::min(a.sensor_count, b.sensor_count))) continue;  // another part
    compare(quote("sensor", std::string(get_name(item.name))), "value", a.sensors[i], b.sensors[i], differences);
  }
  return differences;
}

}  // namespace unlatch::hil
