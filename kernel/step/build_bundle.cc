// The part of bundles that allocates.
#include <algorithm>
#include <new>
#include <utility>

#include "kernel/step/bundle.h"

namespace unlatch {
namespace {

constexpr std::align_val_t kAlignment{64};  // a cache line, as a workspace requires

void free_memory(std::byte* memory) { ::operator delete(memory, kAlignment); }

bool is_fit(const Model& model, const Plan& plan) {
  const PlanData& data = get_data(plan);
  return data.loops.empty() && data.non_tree_joints.empty() && data.flexible.empty() && data.rigid_pairs == 0 &&
         model.contact_substeps == data.contact_substeps;
}

bool has_same_surroundings(const Model& a, const Model& b) {
  return a.gravity.uniform == b.gravity.uniform && a.gravity.mu == b.gravity.mu &&
         a.gravity.centre == b.gravity.centre && a.environment == b.environment;
}

// Places of a model's lists behind those of the models before it.
class MemberPlacer {
 public:
  explicit MemberPlacer(std::span<const Model* const> models, std::span<const Plan* const> plans) {
    for (const Model* model : models) {
      const auto counts = count_elements(*model);
      for (std::size_t kind = 1; kind < kElementKinds; ++kind)
        for (std::size_t other = 0; other < kind; ++other) elements_[kind] += counts[other];
    }
    for (const Plan* plan : plans) totals_ += static_cast<std::int32_t>(get_data(*plan).varying.size());
  }

  BundleMember place(const Model& model, const PlanData& plan, const PlanData& joined) {
    BundleMember member = next_;
    for (const PlanCoordinate& own : get_driven(plan)) {
      const auto is_same = [&](const PlanCoordinate& c) {
        return c.joint == own.joint + member.joint && c.row == own.row;
      };
      const std::span<const PlanCoordinate> all = get_driven(joined);
      member.coordinates.push_back(static_cast<std::int32_t>(std::ranges::find_if(all, is_same) - all.begin()));
    }
    std::int32_t own = 0;
    const auto counts = count_elements(model);
    for (std::size_t kind = 0; kind < kElementKinds; ++kind) {
      member.elements[kind] = {own, elements_[kind], counts[kind]};
      own += counts[kind];
      elements_[kind] += counts[kind];
    }
    const auto burnt = static_cast<std::int32_t>(plan.varying.size());
    const auto totals = static_cast<std::int32_t>(plan.initial_auxiliary.size()) - burnt;
    member.auxiliary = {{{0, burnt_, burnt}, {burnt, totals_, totals}}};
    burnt_ += burnt;
    totals_ += totals;
    const auto pass = [](std::int32_t& place, const auto& list) { place += static_cast<std::int32_t>(list.size()); };
    pass(next_.body, plan.bodies);
    pass(next_.joint, plan.joints);
    pass(next_.event, plan.events);
    pass(next_.pair, plan.contact_pairs);
    pass(next_.one_sided, plan.one_sided);
    pass(next_.bearing, plan.drums);
    pass(next_.load, plan.loads);
    pass(next_.friction, plan.frictions);
    pass(next_.law, plan.laws.list);
    pass(next_.table, plan.laws.tables);
    pass(next_.aerodynamics, plan.aerodynamics);
    next_.law_place += plan.law_numbers.places;
    next_.signal += plan.signal_count;
    next_.sensor += plan.sensor_count;
    next_.quantity += plan.quantity_count;
    next_.channel += plan.channel_count;
    return member;
  }

 private:
  static std::span<const PlanCoordinate> get_driven(const PlanData& plan) {
    return std::span(plan.coordinates).first(at(plan.driven_coordinates));
  }

  BundleMember next_{};
  std::array<std::int32_t, kElementKinds> elements_{};
  std::int32_t burnt_ = 0, totals_ = 0;
};

}  // namespace

BundleData::BundleData(Plan plan_in)
    : plan(std::move(plan_in)),
      commands(at(get_data(plan).channel_count)),
      memory(static_cast<std::byte*>(::operator new(plan.get_workspace_bytes(), kAlignment)), free_memory) {
  std::fill_n(memory.get(), plan.get_workspace_bytes(), std::byte{0});
  workspace = Workspace(plan, {memory.get(), plan.get_workspace_bytes()});
  init_state(plan, get_data(workspace).kept.state);
}

Bundle::Bundle(std::unique_ptr<BundleData> data) : data_(std::move(data)) {}
Bundle::Bundle(Bundle&&) noexcept = default;
Bundle& Bundle::operator=(Bundle&&) noexcept = default;
Bundle::~Bundle() = default;

std::optional<Bundle> Bundle::build(std::span<const Model* const> models, std::span<const Plan* const> plans) {
  if (models.size() < 2 || models.size() > kMost || plans.size() != models.size()) return std::nullopt;
  for (std::size_t m = 0; m < models.size(); ++m)
    if (!is_fit(*models[m], *plans[m]) || !has_same_surroundings(*models[m], *models[0])) return std::nullopt;
  PlanResult joined = compile_plan(join_models(models), plans[0]->get_options());
  if (!joined.plan) return std::nullopt;
  auto data = std::make_unique<BundleData>(*std::move(joined.plan));
  MemberPlacer placer(models, plans);
  for (std::size_t m = 0; m < models.size(); ++m)
    data->members.push_back(placer.place(*models[m], get_data(*plans[m]), get_data(data->plan)));
  return Bundle(std::move(data));
}

}  // namespace unlatch
