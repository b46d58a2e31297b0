#include "tools/report/frames.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>

#include "hil/scenario/base/index.h"
#include "hil/scenario/text/base64.h"
#include "unlatch/contacts.h"
#include "unlatch/readings.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostFrames = 4000;   // besides those near events
constexpr std::int64_t kAround = 5;         // ticks before and after an event that are all kept,
constexpr std::int64_t kMostPinned = 1000;  // until there are so many

void put(const Vec3& v, float*& to) {
  for (const double value : {v.x, v.y, v.z}) *to++ = static_cast<float>(value);
}

template <class T>
std::string encode_base64(const std::vector<T>& values) {
  static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values.data());
  return hil::to_base64({bytes, values.size() * sizeof(T)});
}

}  // namespace

FrameLayout::FrameLayout(const hil::Scenario& scenario, std::size_t sensor_values, std::size_t received_count)
    : joints(bodies + kBodyColumns * scenario.model.bodies.size()),
      loads(joints + kJointColumns * scenario.model.joints.size()),
      pairs(loads + scenario.model.loads.size()),
      channels(pairs + scenario.clearance.size()),
      sensors(channels + scenario.model.channels.size()),
      points(sensors + sensor_values),
      springs(points + kPointColumns * scenario.points.size()),
      one_sided(springs + kSpringColumns * scenario.model.point_springs.size()),
      contacts(one_sided + kOneSidedColumns * scenario.model.one_sided.size()),
      requirements(contacts + kContactColumns * scenario.model.contacts.size()),
      width(requirements + scenario.requirements.size()) {
  for (const Body& body : scenario.model.bodies) {
    modal.push_back(width);
    if (body.flexible) width += static_cast<std::size_t>(body.flexible->frequencies.size());
  }
  received = width;
  received_values = received_count;
  width += received_values;
}

FrameRecorder::FrameRecorder(const hil::Scenario& scenario, const hil::Simulation& simulation,
                             const hil::RunAnalysis& analysis, hil::SensorsShown shown)
    : scenario_(scenario),
      simulation_(simulation),
      analysis_(analysis),
      layout_(scenario, simulation.workspace().sensors.size(),
              hil::shows_received(scenario, shown) ? simulation.get_sensors().size() : 0) {}

void FrameRecorder::look(const StepReport& report, std::span<const hil::LogReceived> received) {
  ++seen_;
  recent_.push_back(take(received));
  if (!report.events.empty() && pinned_ < kMostPinned) {
    for (Frame& frame : recent_) pinned_ += std::exchange(frame.pinned, true) ? 0 : 1;
    pin_until_ = recent_.back().tick + kAround;
  } else if (recent_.back().tick <= pin_until_) {
    recent_.back().pinned = true;
    ++pinned_;
  }
  if (static_cast<std::int64_t>(recent_.size()) > kAround) settle();
}

// The oldest of the recent frames is kept or forgotten.
void FrameRecorder::settle() {
  Frame& frame = recent_.front();
  if (kept_.empty()) frame.pinned = true;
  if (frame.pinned || frame.tick % every_ == 0) kept_.push_back(std::move(frame));
  recent_.pop_front();
  if (kept_.size() > kMostFrames + static_cast<std::size_t>(pinned_)) thin();
}

// Half as many of those that no event holds; once there are none, of all.
void FrameRecorder::thin() {
  const std::size_t before = kept_.size();
  every_ *= 2;
  std::erase_if(kept_, [this](const Frame& frame) { return !frame.pinned && frame.tick % every_ != 0; });
  if (kept_.size() < before || every_ <= kept_.back().tick) return;
  for (std::size_t i = 1; i + 1 < kept_.size(); i += 2) kept_[i].pinned = false;
}

FrameRecorder::Frame FrameRecorder::take(std::span<const hil::LogReceived> received) const {
  const unlatch::State& state = simulation_.state();
  Frame frame{state.header->tick, state.bodies[0].p, std::vector<float>(layout_.width), false};
  float* to = frame.values.data();
  for (const BodyState& body : state.bodies) {
    put(body.p - frame.origin, to);
    for (const double value : {body.q.w, body.q.x, body.q.y, body.q.z}) *to++ = static_cast<float>(value);
    put(body.v, to);
    put(body.w, to);
  }
  for (std::size_t joint = 0; joint < state.joints.size(); ++joint) {
    *to++ = static_cast<float>(state.joints[joint].mode);
    for (std::size_t row = 0; row < kRows; ++row) {
      *to++ = static_cast<float>(simulation_.workspace().multipliers[joint * kRows + row]);
    }
  }
  take_loads(to);
  to = frame.values.data() + layout_.pairs;
  for (const hil::Clearance& clearance : analysis_.clearances()) *to++ = static_cast<float>(clearance.now);
  for (const double value : simulation_.get_inputs()) *to++ = static_cast<float>(value);
  for (const double value : simulation_.workspace().sensors) *to++ = static_cast<float>(value);
  take_points(to);
  take_springs(frame.values.data() + layout_.springs);
  take_one_sided(frame.values.data() + layout_.one_sided);
  take_contacts(frame.values.data() + layout_.contacts);
  for (std::size_t i = 0; i < scenario_.requirements.size(); ++i)
    frame.values[layout_.requirements + i] = static_cast<float>(analysis_.get_requirement_now(i));
  take_modal(frame.values.data());
  to = frame.values.data() + layout_.received;
  for (std::size_t i = 0; i < layout_.received_values; ++i) to[i] = static_cast<float>(simulation_.get_sensors()[i]);
  for (const hil::LogReceived& one : received)
    if (one.value >= 0 && static_cast<std::size_t>(one.value) < layout_.received_values)
      to[one.value] = static_cast<float>(one.received);
  return frame;
}

void FrameRecorder::take_loads(float* to) const {
  for (std::size_t i = 0; i < scenario_.model.loads.size(); ++i)
    to[i] = static_cast<float>(calc_load_size(simulation_.plan(), {simulation_.get_inputs()}, simulation_.state(),
                                              simulation_.workspace(), static_cast<int>(i)));
}

void FrameRecorder::take_points(float* to) const {
  const std::span<const BodyState> bodies = simulation_.state().bodies;
  for (const hil::TracedPoint& point : scenario_.points) {
    const BodyState& body = bodies[static_cast<std::size_t>(point.body)];
    const Vec3 p_BP{point.p_BP.x(), point.p_BP.y(), point.p_BP.z()};
    Vec3 p = body.p + rotation_matrix(body.q) * p_BP;
    if (point.seen_from != kGround) {
      const BodyState& from = bodies[static_cast<std::size_t>(point.seen_from)];
      p = transpose_times(rotation_matrix(from.q), p - from.p);
    }
    put(p, to);
  }
}

void FrameRecorder::take_springs(float* to) const {
  for (std::size_t i = 0; i < scenario_.model.point_springs.size(); ++i) {
    const SpringReading spring = calc_point_spring(simulation_.plan(), simulation_.state(), static_cast<int>(i));
    for (const double value : {spring.force, spring.length, spring.scale}) *to++ = static_cast<float>(value);
  }
}

void FrameRecorder::take_one_sided(float* to) const {
  const Model& model = scenario_.model;
  const int first = hil::get_first_one_sided(model);
  for (int i = 0; i < static_cast<int>(model.one_sided.size()); ++i) {
    const ElementReading force = calc_element(simulation_.plan(), simulation_.workspace(), first + i);
    const double bearing = calc_one_sided(simulation_.plan(), simulation_.workspace(), i).bearing;
    for (const double value : {force.force, force.length, force.scale, force.stroke, bearing, force.wound})
      *to++ = static_cast<float>(value);
  }
}

void FrameRecorder::take_contacts(float* to) const {
  for (std::size_t i = 0; i < scenario_.model.contacts.size(); ++i) {
    const ContactReading contact = calc_contact(simulation_.plan(), simulation_.state(), static_cast<int>(i));
    for (const double value : {contact.normal, contact.friction, contact.depth, contact.slip})
      *to++ = static_cast<float>(value);
  }
}

void FrameRecorder::take_modal(float* frame) const {
  for (std::size_t b = 0; b < scenario_.model.bodies.size(); ++b) {
    float* to = frame + layout_.modal[b];
    for (const double value : get_modal_coordinates(simulation_.plan(), simulation_.state(), static_cast<int>(b)))
      *to++ = static_cast<float>(value);
  }
}

// Columns that are not the same in all frames.
std::vector<std::size_t> FrameRecorder::find_varying() const {
  std::vector<std::size_t> varying;
  const auto get_bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  for (std::size_t column = 0; column < layout_.width; ++column) {
    const std::uint32_t first = get_bits(kept_.front().values[column]);
    if (std::any_of(kept_.begin(), kept_.end(), [&](const Frame& f) { return get_bits(f.values[column]) != first; })) {
      varying.push_back(column);
    }
  }
  return varying;
}

nlohmann::ordered_json FrameRecorder::build_json(std::size_t budget) {
  if (!recent_.empty()) recent_.back().pinned = true;
  while (!recent_.empty()) settle();
  std::vector<std::size_t> varying = find_varying();
  while (kept_.size() > 2 && kept_.size() * (varying.size() * sizeof(float) + 4 * sizeof(double)) > budget) thin();

  std::vector<double> ticks, origins;
  std::vector<float> values;
  for (const Frame& frame : kept_) {
    ticks.push_back(static_cast<double>(frame.tick));
    for (const double value : {frame.origin.x, frame.origin.y, frame.origin.z}) origins.push_back(value);
  }
  for (const std::size_t column : varying) {
    for (const Frame& frame : kept_) values.push_back(frame.values[column]);
  }
  return {{"count", kept_.size()},
          {"seen", seen_},
          {"every", every_},
          {"around", kAround},
          {"first", kept_.front().values},
          {"varying", varying},
          {"ticks", encode_base64(ticks)},
          {"origins", encode_base64(origins)},
          {"values", encode_base64(values)}};
}

}  // namespace unlatch::tools
