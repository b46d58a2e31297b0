// Tables that were looked up beyond their ends, and laws that steps pass over, in words.
#pragma once

#include <string>

#include "hil/run/motion/law_watch.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/text/number_text.h"
#include "unlatch/workspace.h"

namespace unlatch::hil {

// "table 'cx', axis mach: 5.2 is above 5".
inline std::string describe_exit(const Table& table, const TableExit& exit) {
  const TableAxis& axis = table.axes.at(static_cast<std::size_t>(exit.axis));
  const bool below = exit.value < axis.knots.front();
  return "table '" + table.name + "', axis " + (axis.name.empty() ? std::to_string(exit.axis + 1) : axis.name) + ": " +
         write_short(exit.value) + " is " + (below ? "below " : "above ") +
         write_short(below ? axis.knots.front() : axis.knots.back());
}

// One sentence about what a step passed over.
inline std::string describe(const Law& law, const PassedOver& passed) {
  const std::string unit = law.unit == "1" ? "" : " " + law.unit;
  if (passed.step == 0)
    return format(
        "it jumps within a step, or all but jumps, near %.6g s, to %.4g%s: write the jump with `if_less`, whose jumps "
        "are located",
        passed.time, passed.value, unit.c_str());
  return format(
      "it rises or falls to %.4g%s at %.6g s, within a step and unseen by it, which misses %.2g of its impulse: a step "
      "of %.3g s would do",
      passed.value, unit.c_str(), passed.time, passed.error, passed.step);
}

}  // namespace unlatch::hil
