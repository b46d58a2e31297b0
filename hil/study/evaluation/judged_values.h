// Results of one sample at two steps compared: the largest difference of the values that a campaign or a problem
// judges.
//
// Judged are requirements and chosen outputs, and columns that the caller names. If there are none of them: all columns
// but the times of least distances, which move far where a distance hardly changes.
//
// A difference is relative to a scale: of a requirement its value or its limit, whichever is larger; of a time the
// run's length; of a reaction the largest of its joint, of a moment also the joint's force times its arm; of a
// component of a vector (core.vx) the largest component, of a curve its largest point; of others the value. A scale is
// at least 1e-6 of the SI unit, so that rounding of what is at rest limits nothing.
#pragma once

#include <string>
#include <vector>

#include "hil/study/evaluation/evaluation.h"

namespace unlatch::hil {

class JudgedValues {
 public:
  // Keeps a reference to the evaluator. `also`: columns that are judged whatever they are.
  explicit JudgedValues(const SampleEvaluator& evaluator, const std::vector<std::size_t>& also = {});

  struct Difference {
    double size =
        0;           // relative; infinite if only one of both has the value, or the run at the larger step is no result
    std::string of;  // column, or what is no result
  };
  // `coarse`, `fine`: the same sample at a larger and a smaller step. Two samples that fault differ by nothing.
  [[nodiscard]] Difference compare(const SampleResult& coarse, const SampleResult& fine) const;

 private:
  struct Value {
    std::size_t column = 0, group = 0;
  };
  struct Group {
    double least = 0;  // scale that it has at least
  };
  void add(std::size_t column);
  std::size_t add_group(const std::string& key, double least);

  const SampleEvaluator& evaluator_;
  std::vector<Value> values_;
  std::vector<Group> groups_;
  std::vector<std::string> keys_;  // of the groups
};

}  // namespace unlatch::hil
