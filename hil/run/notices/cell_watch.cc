#include "hil/run/notices/cell_watch.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

// Knots that are passed on the way between two places.
double count_passed(const std::vector<double>& knots, double from, double to) {
  const auto low = std::ranges::upper_bound(knots, std::min(from, to));
  return static_cast<double>(std::upper_bound(low, knots.end(), std::max(from, to)) - low);
}

// An angle went on at the other end of the axis.
bool has_turned(const std::vector<double>& knots, double from, double to) {
  constexpr double kWhole = 0.9;
  constexpr std::size_t kFine = 8;  // knots
  return knots.size() >= kFine && std::abs(to - from) > kWhole * (knots.back() - knots.front());
}

}  // namespace

CellWatch::CellWatch(const Model& model) : model_(model) {
  const std::vector<std::vector<int>> bodies = list_bodies_of_laws(model);
  for (const TableLookup& lookup : list_table_lookups(model))
    if (!bodies[at(lookup.law)].empty()) watched_.push_back({lookup, bodies[at(lookup.law)]});
}

std::span<const SkippedCells> CellWatch::update(std::span<const double> places, bool jumps) {
  skipped_.clear();
  if (watched_.empty()) return {};
  for (const Watched& watched : watched_) {
    if (places_.empty() || jumps) break;
    const Table& table = model_.tables[at(watched.lookup.table)];
    const double followed = table.interpolation == Table::Interpolation::kLinear ? kMostCorners : 1;
    for (std::size_t a = 0; a < table.axes.size(); ++a) {
      const std::vector<double>& knots = table.axes[a].knots;
      const double from = places_[at(watched.lookup.place) + a], to = places[at(watched.lookup.place) + a];
      const double passed = count_passed(knots, from, to);
      if (passed > followed && !has_turned(knots, from, to))
        skipped_.push_back({watched.lookup.table, static_cast<int>(a), passed - 1, from, to, watched.bodies});
    }
  }
  places_.assign(places.begin(), places.end());
  return skipped_;
}

}  // namespace unlatch::hil
