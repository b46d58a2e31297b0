// Tables and laws: where they are left, and what the steps pass over.
#include <algorithm>

#include "hil/run/motion/law_watch.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
#include "hil/run/notices/table_exit.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/law_places.h"

namespace unlatch::hil {

// Tables that are left where this is a notice.
void NoticeWatch::watch_tables() {
  const std::span<const TableExit> exits = simulation_.workspace().table_exits;
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const TableExit& exit = exits[i];
    if (exit.axis == kNone || exit.end != TableAxis::End::kNotice) continue;
    const Table& table = scenario_.model.tables[i];
    const std::vector<double>& knots = table.axes[at(exit.axis)].knots;
    const double beyond = std::max(knots.front() - exit.value, exit.value - knots.back());
    report(left_[i], "table", table.name, beyond / (knots.back() - knots.front()),
           [&] { return describe_exit(table, exit) + ": the value at the end holds"; });
  }
}

// Tables that a step skips cells of.
void NoticeWatch::watch_cells(const StepReport& step) {
  for (const SkippedCells& skipped : cells_.update(get_law_places(simulation_.workspace()), !step.events.empty())) {
    const Table& table = scenario_.model.tables[at(skipped.table)];
    const std::string& axis = table.axes[at(skipped.axis)].name;
    report(
        skipped_[at(skipped.table)], "cell", table.name, skipped.cells,
        [&] {
          return format(
              "a step passes %.0f whole cells of its axis %s, from %.4g to %.4g: a smaller step, or a coarser table, "
              "would do",
              skipped.cells, axis.empty() ? std::to_string(skipped.axis + 1).c_str() : axis.c_str(), skipped.from,
              skipped.to);
        },
        skipped.bodies);
  }
}

// Laws that a step passes over.
void NoticeWatch::watch_laws() {
  if (!begun_ || laws_->is_empty()) return;
  for (const PassedOver& passed : laws_->update(simulation_.get_motion(), simulation_.get_inputs())) {
    const Law& law = scenario_.model.laws[at(passed.law)];
    report(
        passed_over_[at(passed.law)], "law", law.name, passed.error, [&] { return hil::describe(law, passed); },
        passed.bodies);
  }
}

}  // namespace unlatch::hil
