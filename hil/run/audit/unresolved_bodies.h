// Bodies whose motion depends on something that the step did not resolve: the bodies of a contact, a spring, a rate, a
// search, and every body that links of the run (body_links.h) connect to them, at the time of the error or later.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "hil/run/audit/body_links.h"
#include "hil/run/audit/speed_readers.h"
#include "hil/scenario/requirements.h"
#include "unlatch/model.h"

namespace unlatch::hil {

class UnresolvedBodies {
 public:
  // Keeps a reference.
  explicit UnresolvedBodies(const Model& model);

  // Adds a cause that reached these bodies at a time, s. Each body keeps its first cause.
  void add(std::span<const int> bodies, const std::string& cause, double time);
  // Adds a cause that this body had from one time until another, s, and has no more: values of that while depend on it.
  void add_passed(int body, const std::string& cause, double from, double until, const BodyLinks& links);
  // Adds a cause that a speed alone had, and nothing else: between two times, s. For requirements that read it.
  void add_speed(const SpeedReaders& readers, const std::string& cause, double from, double until);
  // Spreads causes through the links of the whole run so far.
  void spread(const BodyLinks& links);

  // Cause on which the requirement's value depends, for an interval that ends at `until`, s, and a value that is taken
  // at `time`, s; empty if there is none.
  [[nodiscard]] std::string find_cause(const Requirement& requirement, double until, double time) const;

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Entry {
    double time = kNever;
    std::string cause;
  };
  struct Passed {
    int body = 0;
    double from = 0, until = 0;  // s
    std::string cause;
  };

  struct Speed {
    SpeedReaders readers;
    double from = 0, until = 0;  // s
    std::string cause;
  };

  const Model& model_;
  std::vector<Entry> bodies_;
  std::vector<Passed> passed_;
  std::vector<Speed> speeds_;
  double first_ = kNever;  // s
};

}  // namespace unlatch::hil
