// Links of a run: through which the motion of one body reaches that of another, and when. Joints with any row and
// elements between two bodies that are switched on (springs, contacts, pushers, cords, stops, whether they engage or
// not) link both; a law links the bodies that it reads to the one that it pushes; an event links the bodies of its
// guard to those that it acts on, as long as it may act; commands that change link the bodies that sensors measure to
// those that are commanded. The ground links nothing. Cost: one pass over all links at the start and at instants of
// events.
#pragma once

#include <limits>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

class BodyLinks {
 public:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  // Keeps a reference.
  explicit BodyLinks(const Model& model);

  // The state at the start, and just before and after each instant of events; times do not fall, s.
  void update(const State& state, double time);
  // Commands have changed at this time, s.
  void add_command(double time);

  // When errors of bodies, each from a time on, reach every body, s; in `sources` the body that each came from.
  // `times`: kNever for a body without an error.
  void spread(std::vector<double>& times, std::vector<int>& sources) const;

 private:
  enum class Kind { kJoint, kElement, kEvent, kCommand };
  struct Period {
    double from = 0, until = kNever;  // s
  };
  struct Link {
    Kind kind = Kind::kJoint;
    int subject = 0;       // joint or event; of an element its number among all of them
    int a = 0, b = 0;      // from a to b, and
    bool returns = false;  // from b to a
    std::vector<Period> periods{};
  };
  // More periods of one link are joined, with those between.
  static constexpr std::size_t kMostPeriods = 16;

  void add(Kind kind, int subject, const std::vector<int>& pair);
  void add_ways(Kind kind, int subject, const std::vector<int>& from, const std::vector<int>& to);
  [[nodiscard]] bool is_on(const Link& link, const State& state) const;

  const Model& model_;
  std::vector<Link> links_;
};

}  // namespace unlatch::hil
