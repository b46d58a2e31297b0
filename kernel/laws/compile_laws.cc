#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <tuple>

#include "kernel/environment/environment_model.h"
#include "kernel/laws/law_graph.h"
#include "kernel/laws/law_model.h"
#include "kernel/laws/table_weights.h"
#include "kernel/laws/tables.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

std::int32_t get_size(const auto& list) { return static_cast<std::int32_t>(list.size()); }

// Twice as many uniform parts as cells. On one so short that the scale overflows all knots but the first are in the
// last.
void compile_buckets(std::span<const double> knots, PlanLawLists<GrowingList>& plan, PlanTableAxis& axis) {
  axis.bucket_count = 2 * (axis.count - 1);
  axis.bucket_scale = axis.bucket_count / (knots.back() - knots.front());
  axis.buckets = get_size(plan.buckets);
  // A coordinate in part b is not before the knots of earlier parts, and before those of later ones: rounding is
  // monotone.
  std::int32_t before = 0;
  for (std::int32_t b = 0; b <= axis.bucket_count; ++b) {
    while (before < axis.count && find_bucket(axis, knots[0], knots[at(before)]) < b) ++before;
    plan.buckets.push_back(std::max(0, before - 1));
  }
}

// Weights of each cell's support, as polynomials.
void compile_cells(std::span<const double> knots, PlanLawLists<GrowingList>& plan, PlanTableAxis& axis) {
  axis.cells = get_size(plan.numbers);
  for (std::int32_t cell = 0; cell + 1 < axis.count; ++cell)
    for (const std::array<double, 4>& weight : calc_cell_weights(knots, cell))
      plan.numbers.insert(plan.numbers.end(), weight.begin(), weight.end());
}

class TableCompiler {
 public:
  explicit TableCompiler(PlanDraft& plan) : plan_(plan.laws), strict_(plan.law_numbers.strict) {}

  void compile(const Table& table) {
    const Content content{list_axes(table), &table.values, table.interpolation};
    const auto [found, is_new] = known_.emplace(content, plan_.tables.size());
    PlanTable out = is_new ? append(table) : plan_.tables[found->second];
    out.scale = table.scale, out.offset = table.offset;
    out.scale_channel = table.scale_channel, out.offset_channel = table.offset_channel;
    plan_.tables.push_back(out);
    for (const TableAxis& axis : table.axes)
      strict_ = strict_ || axis.below == TableAxis::End::kError || axis.above == TableAxis::End::kError;
  }

 private:
  // Compared by what it points to. Joined models have the tables of each run.
  struct Content {
    std::vector<std::tuple<std::vector<double>, TableAxis::End, TableAxis::End>> axes;
    const std::vector<double>* values;
    Table::Interpolation interpolation;
    bool operator<(const Content& other) const {
      return std::tie(axes, *values, interpolation) < std::tie(other.axes, *other.values, other.interpolation);
    }
  };
  static decltype(Content::axes) list_axes(const Table& table) {
    decltype(Content::axes) list;
    for (const TableAxis& axis : table.axes) list.emplace_back(axis.knots, axis.below, axis.above);
    return list;
  }

  PlanTable append(const Table& table) {
    PlanTable out{};
    out.smooth = table.interpolation == Table::Interpolation::kSmooth;
    out.first_axis = get_size(plan_.axes);
    out.axis_count = get_size(table.axes);
    std::int32_t stride = get_size(table.values);
    for (const TableAxis& axis : table.axes) {
      PlanTableAxis own{};
      own.knots = get_size(plan_.numbers);
      own.count = get_size(axis.knots);
      own.support = out.smooth ? std::min(own.count, kCellKnots) : 2;
      own.stride = stride /= own.count;
      own.below = axis.below, own.above = axis.above;
      plan_.numbers.insert(plan_.numbers.end(), axis.knots.begin(), axis.knots.end());
      compile_buckets(axis.knots, plan_, own);
      if (out.smooth) compile_cells(axis.knots, plan_, own);
      plan_.axes.push_back(own);
    }
    out.values = get_size(plan_.numbers);
    plan_.numbers.insert(plan_.numbers.end(), table.values.begin(), table.values.end());
    if (!out.smooth) return out;
    const std::span<double> numbers = std::span(plan_.numbers).subspan(at(out.values));
    for (std::size_t a = 0; a < table.axes.size(); ++a)
      solve_spline(table.axes[a].knots, numbers, plan_.axes[at(out.first_axis) + a].stride);
    return out;
  }

  PlanLawLists<GrowingList>& plan_;
  bool& strict_;
  std::map<Content, std::size_t> known_;
};

class LawCompiler {
 public:
  LawCompiler(const Model& model, ElementCompiler& compiler)
      : model_(model), graph_(build_law_graph(model)), compiler_(compiler), plan_(compiler.plan.laws) {}

  void compile() {
    for (const bool driving : {true, false}) {
      for (const int law : graph_.order)
        if (graph_.driving[at(law)] == driving) {
          plan_.order.push_back(law);
          find_operands(model_.laws[at(law)], driving);
        }
      if (!driving) break;
      compiler_.plan.law_numbers.driving = get_size(plan_.order);
      compiler_.plan.law_numbers.driving_operands = get_size(plan_.operands);
    }
    compiler_.plan.law_numbers.places = 0;
    zero_ = get_size(plan_.numbers);
    plan_.numbers.push_back(0);
    const std::vector<std::vector<int>> bodies = list_air_bodies(model_, graph_.driving);
    for (std::size_t i = 0; i < model_.laws.size(); ++i) {
      append(model_.laws[i], graph_.driving[i]);
      for (const int body : bodies[i]) append_air(body);
    }
  }

 private:
  const Quantity* get_quantity(const LawStep& step) const {
    return step.kind == LawStep::Kind::kQuantity ? &model_.quantities[at(step.subject)] : nullptr;
  }

  // The model's quantities are the first of the plan.
  void find_operands(const Law& law, bool driving) {
    for (const LawStep& step : law.steps) {
      const Quantity* quantity = get_quantity(step);
      if (quantity == nullptr || quantity->kind == Quantity::Kind::kLaw) continue;
      if (!operands_.emplace(step.subject, get_size(plan_.operands)).second) continue;
      plan_.operands.push_back(step.subject);
      if (driving && (get_traits(quantity->kind).reads & kReadsCoordinate) != 0)
        compiler_.find_coordinate(quantity->subject, quantity->part);
    }
  }

  void append(const Law& law, bool driving) {
    plan_.list.push_back(
        {get_size(plan_.steps), get_size(law.steps), law.scale_channel, law.offset_channel, law.scale, law.offset});
    for (const LawStep& step : law.steps) {
      PlanLawStep out{step.kind, step.subject, step.value, kNone, false};
      if (const int count = count_law_places(model_, step); count > 0) {
        out.place = compiler_.plan.law_numbers.places;
        compiler_.plan.law_numbers.places += count;
        if (driving) append_corners(step, out.place);
      }
      if (const Quantity* quantity = get_quantity(step)) {
        out.of_law = quantity->kind == Quantity::Kind::kLaw;
        out.subject = out.of_law ? quantity->subject : operands_.at(step.subject);
      }
      plan_.steps.push_back(out);
    }
  }

  // A linear table has corners at its knots, a smooth one where it is left, a branch where it changes.
  void append_corners(const LawStep& step, std::int32_t place) {
    if (step.kind != LawStep::Kind::kTable) {
      plan_.corners.push_back({place, zero_, 1, step.kind == LawStep::Kind::kIfLess});
      return;
    }
    const PlanTable& table = plan_.tables[at(step.subject)];
    for (std::int32_t a = 0; a < table.axis_count; ++a) {
      const PlanTableAxis& axis = plan_.axes[at(table.first_axis + a)];
      if (!table.smooth) {
        plan_.corners.push_back({place + a, axis.knots, axis.count, false});
        continue;
      }
      plan_.corners.push_back({place + a, axis.knots, 1, false});
      plan_.corners.push_back({place + a, axis.knots + axis.count - 1, 1, false});
    }
  }

  // The altitude of a body, whose corners are those of the air.
  void append_air(int body) {
    if (plan_.air_places.empty()) {
      const std::vector<double> corners = compile_environment(model_.environment).corners;
      air_ = get_size(plan_.numbers), air_count_ = get_size(corners);
      plan_.numbers.insert(plan_.numbers.end(), corners.begin(), corners.end());
    }
    const auto own = std::ranges::find(model_.aerodynamics, body, &Aerodynamics::body);
    const bool acts = own != model_.aerodynamics.end();
    const std::int32_t place = compiler_.plan.law_numbers.places++,
                       number = acts ? static_cast<std::int32_t>(own - model_.aerodynamics.begin()) : kNone;
    plan_.air_places.push_back({place, body, number, air_, air_count_});
    plan_.corners.push_back({place, air_, air_count_, false});
  }

  const Model& model_;
  const LawGraph graph_;
  ElementCompiler& compiler_;
  PlanLawLists<GrowingList>& plan_;
  std::map<int, std::int32_t> operands_;  // by the model's number of the quantity
  std::int32_t zero_ = 0;                 // the knot of a branch
  std::int32_t air_ = 0, air_count_ = 0;  // corners of the air, in PlanLaws::numbers
};

// A command decides the value of some law.
bool reads_commands(const Model& model) {
  const auto scaled = [](const auto& item) { return item.scale_channel != kNone || item.offset_channel != kNone; };
  return std::ranges::any_of(model.tables, scaled) || std::ranges::any_of(model.laws, [&](const Law& law) {
           return scaled(law) || std::ranges::any_of(law.steps, [&](const LawStep& step) {
                    return step.kind == LawStep::Kind::kCommand ||
                           (step.kind == LawStep::Kind::kQuantity &&
                            (get_traits(model.quantities[at(step.subject)].kind).reads & kReadsInputs) != 0);
                  });
         });
}

}  // namespace

void compile_laws(const Model& model, ElementCompiler& compiler) {
  if (model.laws.empty()) return;
  TableCompiler tables(compiler.plan);
  for (const Table& table : model.tables) tables.compile(table);
  LawCompiler(model, compiler).compile();
  compiler.plan.commanded_loads = compiler.plan.commanded_loads || reads_commands(model);
}

}  // namespace unlatch
