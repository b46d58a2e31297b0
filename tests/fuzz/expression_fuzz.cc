// Expressions: as numbers, and as laws over a quantity, a channel and a table, which are compiled and stepped.
#include <cmath>

#include "hil/scenario/text/expression.h"
#include "tests/fuzz/fuzz.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

using namespace unlatch;

namespace {

class Names : public hil::LawNames {
 public:
  std::optional<hil::Operand> find_value(const std::string& name) override {
    if (name == "x") return hil::Operand{{1, hil::dimension_of("m")}, {{LawStep::Kind::kQuantity, 0, 0}}};
    if (name == "throttle") return hil::Operand{{1, {}}, {{LawStep::Kind::kCommand, 0, 0}}};
    return std::nullopt;
  }
  std::optional<hil::TableSignature> find_table(const std::string& name) override {
    if (name != "f") return std::nullopt;
    return hil::TableSignature{0, {hil::dimension_of("m"), std::nullopt}, hil::dimension_of("N")};
  }
  std::vector<std::string> list_names() override { return {"x", "throttle", "f"}; }
};

Model build_model() {
  Model model;
  Body& body = model.bodies.emplace_back();
  body.name = "b";
  body.mass = 1;
  body.inertia.setIdentity();
  body.p_WB = {1, 0, 0};
  body.v_WB = {1, 0, 0};
  Quantity& x = model.quantities.emplace_back();
  x.name = "x";
  x.kind = Quantity::Kind::kPosition;
  model.channels.push_back({"throttle", 0.5, 0, 1, 0, "1"});
  Table& table = model.tables.emplace_back();
  table.name = "f";
  table.axes = {{.name = "x", .knots = {0, 1, 2}}, {.name = "y", .knots = {0, 1}}};
  table.values = {0, 1, 2, 3, 4, 5};
  return model;
}

// The law of an accepted expression is a valid one, and its plan steps.
void fly(std::vector<LawStep> steps) {
  static const Model kModel = build_model();
  Model model = kModel;
  Law& law = model.laws.emplace_back();
  law.name = "law";
  law.steps = std::move(steps);
  const PlanResult compiled = compile_plan(model, {.dt = 1e-3});
  if (!compiled.plan) {
    for (const ModelError& error : compiled.errors)
      fuzz::require(error.what.find("keeps more than") != std::string::npos, "a law that its model refuses");
    return;
  }
  const auto aligned = [](std::size_t bytes) { return std::vector<double>(bytes / sizeof(double) + 16); };
  std::vector<double> state_memory = aligned(compiled.plan->get_state_bytes()),
                      workspace_memory = aligned(compiled.plan->get_workspace_bytes());
  const auto get = [](std::vector<double>& memory, std::size_t bytes) {
    void* first = memory.data();
    std::size_t space = memory.size() * sizeof(double);
    return std::span(static_cast<std::byte*>(std::align(64, bytes, first, space)), bytes);
  };
  State state(*compiled.plan, get(state_memory, compiled.plan->get_state_bytes()));
  Workspace workspace(*compiled.plan, get(workspace_memory, compiled.plan->get_workspace_bytes()));
  init_state(*compiled.plan, state);
  const double commands[] = {0.5};
  for (int i = 0; i < 2; ++i)
    fuzz::require(step(*compiled.plan, {commands}, state, workspace).status == StepStatus::kOk, "a step that failed");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::to_text(data, size);
  try {
    fuzz::require(std::isfinite(hil::evaluate_expression(text, {}).value), "a number that is not finite");
  } catch (const hil::ExpressionError&) {  // refused
  }
  try {
    Names names;
    hil::Operand operand = hil::compile_expression(text, {}, names);
    if (operand.is_constant()) operand.steps = {{LawStep::Kind::kConstant, 0, operand.quantity.value}};
    fly(std::move(operand.steps));
  } catch (const hil::ExpressionError&) {  // refused
  }
  return 0;
}
