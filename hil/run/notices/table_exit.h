// Tables that were looked up beyond their ends, in words.
#pragma once

#include <string>

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

}  // namespace unlatch::hil
