// Requirements on a run: a quantity, its reduction to one value, and a limit. They do not influence the run and are not
// part of its model. hil/run/analysis/requirements.h evaluates them.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::hil {

// An event that a requirement names. Which occurrence it is: language.yaml, `requirement`.
struct EventName {
  std::string text;   // "release:booster1"; empty: none is named
  int event = kNone;  // index into the model's events; kNone if it is disabled (enabled: false)
  [[nodiscard]] bool is_named() const { return !text.empty(); }
};

struct Requirement {
  enum class Measure {
    kClearance,  // distance between bodies `a` and `b`, m
    kRate,       // |angular velocity| of `a` relative to `b`, or |its component along `direction`|, axes of `a`, rad/s
    kTime,       // time of events[0], or from events[1] to events[0], s
    kOrder,      // smallest time from one of `events` to the next, s
    kReaction,   // multiplier of row `axis` of joint `a`, or the size of the force or moment, N or N m
    kVelocity,   // velocity of the origin of `a` minus that of `b`, its size or along `direction` in axes of `b`, m/s
    kPosition,   // the same of the position, m
    kDisplacement,  // displacement of the follower's point along `axis` of joint `a`, m
    kAngle,         // angle about `axis` of joint `a`, full turns counted, rad
    kSpeed,         // rate of either, m/s or rad/s
    kAxes,          // angle between `direction` of body `a` and `other` of body `b`, rad, 0 to π
    kSensor,        // value number `axis` of sensor `a`, or the size of all
    kContact,       // ContactValue number `axis` of contact `a`
    kQuantity,      // quantity number `a` of the model
  };
  enum class Take {
    kMinimum,  // smallest value
    kMaximum,  // greatest value
    kPeak,     // greatest absolute value
    kFinal,    // value at the end of the interval
    kBoth,     // smallest and greatest value: the one nearer to its limit, or farther beyond it
  };
  enum class ContactValue { kForce, kDepth, kSlip, kImpulse, kDissipated };  // N, m, m, N s, J
  static constexpr int kSize = -1;                                           // `axis`: the size of a vector
  static constexpr int kForce = -1, kMoment = -2;  // `axis` of kReaction: size of the rows x y z, of rot_x rot_y rot_z

  std::string id, text;
  Measure quantity = Measure::kClearance;
  int a = 0, b = kGround;  // bodies, joint or sensor
  int pair = -1;           // kClearance: index in Scenario::clearance
  std::string pair_name;   // names of the pair: "core – booster1"
  int axis = kSize;        // row, axis or number of the value
  bool received = false;   // kSensor: as flight software receives it, held from sample to sample
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(), other = Eigen::Vector3d::Zero();  // unit vectors; zero: the size
  std::vector<EventName> events;                                                         // events of kTime, kOrder
  EventName at, from, to;  // instant, or beginning and end of the interval; default: those of the run
  Take take = Take::kMinimum;
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();  // limits
  std::string unit;                                                                                         // SI

  // True for a quantity of events: it has one value, not one at each instant.
  [[nodiscard]] bool is_of_events() const { return quantity == Measure::kTime || quantity == Measure::kOrder; }
};

// Key of the quantity in the language: "clearance".
const std::string& get_quantity_name(Requirement::Measure quantity);
// Description for readers: "clearance core – booster1 from release:booster1".
std::string describe_quantity(const Requirement& requirement, const Model& model);

}  // namespace unlatch::hil
