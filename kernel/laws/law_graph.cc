#include "kernel/laws/law_graph.h"

#include <algorithm>

#include "kernel/elements/kinds/kinds.h"
#include "kernel/laws/law_steps.h"
#include "kernel/math/index.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/model/law_places.h"
#include "unlatch/quantities.h"
#include "unlatch/readings.h"

namespace unlatch {
namespace {

// Marks the laws that an element names: its kind passes all its indices to shift(), those of laws among them.
struct LawLister {
  std::vector<bool>& named;

  void shift_body(int&) const {}
  void shift_bodies(int&, int&) const {}
  void shift_joint(int&) const {}
  void shift_surface(int&) const {}
  void shift_channel(int&) const {}
  void shift_law(int& law) const {
    if (law >= 0 && at(law) < named.size()) named[at(law)] = true;
  }
};

std::vector<int> list_laws_read(const Model& model, const Law& law) {
  std::vector<int> read;
  for (const LawStep& step : law.steps)
    if (step.kind == LawStep::Kind::kQuantity && model.quantities[at(step.subject)].kind == Quantity::Kind::kLaw)
      read.push_back(model.quantities[at(step.subject)].subject);
  return read;
}

// Marks all laws that marked laws read, directly or through others. `order`: LawGraph::order.
void mark_laws_read(const Model& model, const std::vector<int>& order, std::vector<bool>& marks) {
  for (std::size_t i = order.size(); i-- > 0;)  // each before those that it reads
    if (marks[at(order[i])])
      for (const int read : list_laws_read(model, model.laws[at(order[i])]))
        if (read >= 0 && at(read) < marks.size()) marks[at(read)] = true;
}

// Depth first, without recursion, which a long chain of laws would make deep. False if a law depends on itself.
class Sorter {
 public:
  explicit Sorter(const Model& model) : model_(model), marks_(model.laws.size(), Mark::kNew) {}

  LawGraph sort() {
    for (std::size_t i = 0; i < marks_.size(); ++i)
      if (marks_[i] == Mark::kNew) visit(static_cast<int>(i));
    return std::move(graph_);
  }

 private:
  enum class Mark { kNew, kOpen, kDone };
  struct Entry {
    int law;
    std::vector<int> reads;
    std::size_t next = 0;
  };

  void visit(int first) {
    std::vector<Entry> stack;
    const auto open = [&](int law) {
      marks_[at(law)] = Mark::kOpen;
      stack.push_back({law, list_laws_read(model_, model_.laws[at(law)])});
    };
    open(first);
    while (!stack.empty()) {
      Entry& top = stack.back();
      if (top.next == top.reads.size()) {
        marks_[at(top.law)] = Mark::kDone;
        graph_.order.push_back(top.law);
        stack.pop_back();
        continue;
      }
      const int other = top.reads[top.next++];
      if (other < 0 || at(other) >= marks_.size()) continue;  // reported with the quantity
      if (marks_[at(other)] == Mark::kOpen)
        graph_.circle.push_back(other);
      else if (marks_[at(other)] == Mark::kNew)
        open(other);
    }
  }

  const Model& model_;
  std::vector<Mark> marks_;
  LawGraph graph_;
};

}  // namespace

std::vector<bool> list_driving_laws(const Model& model) { return build_law_graph(model).driving; }

int count_law_places(const Model& model, const LawStep& step) {
  if (step.kind == LawStep::Kind::kTable) return static_cast<int>(model.tables[at(step.subject)].axes.size());
  return get_operands(step.kind).decides ? 1 : 0;
}

std::vector<std::vector<int>> list_air_bodies(const Model& model, const std::vector<bool>& driving) {
  std::vector<std::vector<int>> bodies(model.laws.size());
  std::vector<bool> read(model.bodies.size());
  for (std::size_t i = 0; i < driving.size(); ++i)
    for (const LawStep& step : model.laws[i].steps) {
      if (!driving[i] || step.kind != LawStep::Kind::kQuantity) continue;
      const Quantity& quantity = model.quantities[at(step.subject)];
      if (!get_traits(quantity.kind).of_air || read[at(quantity.subject)]) continue;
      read[at(quantity.subject)] = true;
      bodies[i].push_back(quantity.subject);
    }
  return bodies;
}

std::vector<TableLookup> list_table_lookups(const Model& model) {
  std::vector<TableLookup> list;
  const std::vector<std::vector<int>> bodies = list_air_bodies(model, list_driving_laws(model));
  int place = 0;
  for (std::size_t i = 0; i < model.laws.size(); ++i) {
    for (const LawStep& step : model.laws[i].steps) {
      if (step.kind == LawStep::Kind::kTable) list.push_back({static_cast<int>(i), step.subject, place});
      place += count_law_places(model, step);
    }
    place += static_cast<int>(bodies[i].size());
  }
  return list;
}

bool has_driving_corners(const Model& model) {
  if (!model.aerodynamics.empty()) return true;
  const std::vector<bool> driving = list_driving_laws(model);
  for (const std::vector<int>& bodies : list_air_bodies(model, driving))
    if (!bodies.empty()) return true;
  for (std::size_t i = 0; i < driving.size(); ++i)
    for (const LawStep& step : model.laws[i].steps)
      if (driving[i] && count_law_places(model, step) > 0) return true;
  return false;
}

std::span<const double> get_law_places(const Workspace& workspace) noexcept {
  return get_data(workspace).kept.evaluation.law_places;
}

LawGraph build_law_graph(const Model& model) {
  LawGraph graph = Sorter(model).sort();
  graph.driving.assign(model.laws.size(), false);
  for_each_kind([&](auto kind) {
    for (auto item : kind.of(model)) kind.shift(item, LawLister{graph.driving});
  });
  mark_laws_read(model, graph.order, graph.driving);
  return graph;
}

std::vector<std::vector<int>> list_bodies_of_laws(const Model& model, Reading reading) {
  const std::vector<int> order = build_law_graph(model).order;
  std::vector<std::vector<int>> bodies(model.laws.size());
  int element = 0;
  std::vector<bool> marks;
  for_each_kind([&](auto kind) {
    for (auto item : kind.of(model)) {
      marks.assign(model.laws.size(), false);
      kind.shift(item, LawLister{marks});
      if (reading == Reading::kAny) mark_laws_read(model, order, marks);
      const std::vector<int> own = list_element_bodies(model, element++);
      for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i])
          for (const int body : own)
            if (std::ranges::find(bodies[i], body) == bodies[i].end()) bodies[i].push_back(body);
    }
  });
  return bodies;
}

std::vector<int> list_laws_behind(const Model& model, int law) {
  const std::vector<int> order = build_law_graph(model).order;
  std::vector<bool> marks(model.laws.size());
  marks[at(law)] = true;
  mark_laws_read(model, order, marks);
  std::vector<int> behind;
  for (const int one : order)
    if (marks[at(one)]) behind.push_back(one);
  return behind;
}

}  // namespace unlatch
