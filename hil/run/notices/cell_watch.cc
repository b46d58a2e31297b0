#include "hil/run/notices/cell_watch.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/model/index.h"

namespace unlatch::hil {
namespace {

// Marks a law and those that it reads, directly or through others. Without recursion: chains may be long.
void mark_laws(const Model& model, int first, std::vector<bool>& marks) {
  std::vector<int> open{first};
  while (!open.empty()) {
    const int law = open.back();
    open.pop_back();
    if (law == kNone || marks[at(law)]) continue;
    marks[at(law)] = true;
    for (const LawStep& step : model.laws[at(law)].steps)
      if (step.kind == LawStep::Kind::kQuantity && model.quantities[at(step.subject)].kind == Quantity::Kind::kLaw)
        open.push_back(model.quantities[at(step.subject)].subject);
  }
}

// Per law the bodies of the forces that read it.
std::vector<std::vector<int>> list_bodies(const Model& model) {
  std::vector<std::vector<int>> bodies(model.laws.size());
  const auto add = [&](int body, const std::vector<bool>& marks) {
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (marks[i] && std::ranges::find(bodies[i], body) == bodies[i].end()) bodies[i].push_back(body);
  };
  for (const Load& load : model.loads) {
    std::vector<bool> marks(model.laws.size());
    if (load.profile.kind == Profile::Kind::kLaw) mark_laws(model, load.profile.law, marks);
    add(load.body, marks);
  }
  for (const Aerodynamics& air : model.aerodynamics) {
    std::vector<bool> marks(model.laws.size());
    for (const AeroTerm& term : air.terms) mark_laws(model, term.law, marks);
    add(air.body, marks);
  }
  return bodies;
}

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
  const std::vector<std::vector<int>> bodies = list_bodies(model);
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
