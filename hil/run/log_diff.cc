#include "hil/run/log_diff.h"

#include <bit>
#include <utility>

#include "hil/run/replay.h"
#include "hil/scenario/text/number_text.h"

namespace unlatch::hil {
namespace {

// One recording, state by state.
class Side {
 public:
  Side(RecordingReader& recording, Simulation& simulation) : recording_(recording), simulation_(simulation) {
    recording_.keeps_states = true;
  }

  // Moves to the next state; false when there is none.
  bool advance() {
    LogTick next;
    if (!recording_.next(next) && !take_end(next)) return false;
    step_inputs_.assign(simulation_.channels().begin(), simulation_.channels().end());
    step_changes_ = std::move(record_.changes);
    made_step_ = record_.tick >= 0;
    record_ = std::move(next);
    if (made_step_ && unreproduced_ < 0 && simulation_.step().status != StepStatus::kOk) unreproduced_ = get_tick();
    if (unreproduced_ < 0 && simulation_.calc_hash() != get_hash()) unreproduced_ = get_tick();
    refuse_if_lossy(recording_, record_.unrecorded);
    for (const LogChange& change : record_.changes) apply(change, simulation_);
    return true;
  }

  [[nodiscard]] std::int64_t get_tick() const { return record_.tick; }
  [[nodiscard]] std::int64_t get_hash() const { return record_.hash; }
  [[nodiscard]] std::int64_t get_unreproduced() const { return unreproduced_; }
  // True if a step led to this state; then its inputs and changes are known.
  [[nodiscard]] bool has_made_step() const { return made_step_; }
  [[nodiscard]] const std::vector<double>& get_step_inputs() const { return step_inputs_; }
  [[nodiscard]] const std::vector<LogChange>& get_step_changes() const { return step_changes_; }
  // Inputs of the step from this state on.
  [[nodiscard]] std::span<const double> get_inputs() const { return std::as_const(simulation_).channels(); }
  [[nodiscard]] const std::vector<StateMessage>& get_recorded_states() const { return recording_.states; }
  [[nodiscard]] const State& get_state() const { return simulation_.state(); }

  [[nodiscard]] LogEnding get_ending() const {
    LogEnding ending{record_.tick, std::nullopt, recording_.shortfall, recording_.damaged, unreproduced_};
    if (recording_.end) {
      ending.status = recording_.end->status;
      ending.message = recording_.end->message;
    }
    return ending;
  }

 private:
  // Treats the end of the recording as one more state, unless the last step failed.
  bool take_end(LogTick& next) {
    if (!recording_.end) return false;
    refuse_if_lossy(recording_, recording_.end->unrecorded);
    if (recording_.end->tick <= record_.tick) return false;
    next = {recording_.end->tick, recording_.end->hash, recording_.end->unrecorded, {}, {}};
    return true;
  }

  RecordingReader& recording_;
  Simulation& simulation_;
  LogTick record_{-1, 0, 0, {}, {}};
  bool made_step_ = false;
  std::vector<double> step_inputs_;
  std::vector<LogChange> step_changes_;
  std::int64_t unreproduced_ = -1;
};

void refuse_other_model(const std::array<RecordingReader*, 2>& recordings) {
  const LogHeader &a = recordings[0]->header, &b = recordings[1]->header;
  const std::string names = recordings[0]->get_name() + " and " + recordings[1]->get_name();
  if (a.scenario_name != b.scenario_name) {
    throw LogError(names + " are of different scenarios, '" + a.scenario_name + "' and '" + b.scenario_name + "'");
  }
  if (a.dt != b.dt) {
    throw LogError(names + " have different steps, " + write_number(a.dt) + " s and " + write_number(b.dt) + " s");
  }
  if (a.model_hash != b.model_hash) {
    throw LogError(names + " are of scenario '" + a.scenario_name +
                   "' with different texts or --set values: different models, whose bits cannot be compared");
  }
}

void note_first_input(const std::array<Side, 2>& sides, std::optional<InputDifference>& input) {
  if (input) return;
  const std::span<const double> a = sides[0].get_inputs(), b = sides[1].get_inputs();
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(a[i]) == std::bit_cast<std::uint64_t>(b[i])) continue;
    input = {sides[0].get_tick(), static_cast<std::int32_t>(i), {a[i], b[i]}};
    return;
  }
}

// Finds the fields at the next tick, from the present one on, for which both recordings have State messages.
void find_recorded_fields(std::array<Side, 2>& sides, const Model& model, StateDifference& difference) {
  do {
    const std::vector<StateMessage>&a = sides[0].get_recorded_states(), &b = sides[1].get_recorded_states();
    if (a.empty() || a.size() != b.size()) continue;
    for (std::size_t i = a.size(); i-- > 0;) {  // part 0 is the last of a tick
      if (a[i].part != b[i].part || a[i].tick != b[i].tick) continue;
      for (FieldDifference& field : compare_states(model, a[i], b[i])) difference.fields.push_back(std::move(field));
      difference.fields_tick = a[i].tick;
    }
    if (!difference.fields.empty()) return;
  } while (sides[0].advance() && sides[1].advance());
  difference.fields_tick = -1;
}

StateDifference build_difference(std::array<Side, 2>& sides, const Model& model) {
  StateDifference difference;
  difference.tick = sides[0].get_tick();
  for (std::size_t k = 0; k < 2; ++k) {
    difference.hashes[k] = sides[k].get_hash();
    difference.changes[k] = sides[k].get_step_changes();
  }
  if (sides[0].has_made_step() && sides[1].has_made_step()) {
    const std::vector<double>&a = sides[0].get_step_inputs(), &b = sides[1].get_step_inputs();
    for (std::size_t i = 0; i < a.size(); ++i) difference.channels.push_back({a[i], b[i]});
  }
  if (sides[0].get_unreproduced() < 0 && sides[1].get_unreproduced() < 0) {
    difference.fields_tick = difference.tick;
    difference.fields = compare_states(model, sides[0].get_state(), sides[1].get_state());
  } else {
    find_recorded_fields(sides, model, difference);
  }
  return difference;
}

}  // namespace

LogDiff diff(std::array<RecordingReader*, 2> recordings, std::array<Simulation*, 2> simulations,
             const std::function<void(std::int64_t)>& look) {
  refuse_other_model(recordings);
  std::array<Side, 2> sides{Side(*recordings[0], *simulations[0]), Side(*recordings[1], *simulations[1])};
  LogDiff result;
  std::array<bool, 2> more{sides[0].advance(), sides[1].advance()};
  while (more[0] && more[1] && sides[0].get_tick() != sides[1].get_tick()) {  // one of them begins at a checkpoint
    const std::size_t behind = sides[0].get_tick() < sides[1].get_tick() ? 0 : 1;
    more[behind] = sides[behind].advance();
  }
  if (!more[0] || !more[1]) {
    throw LogError(recordings[0]->get_name() + " and " + recordings[1]->get_name() + " have no tick in common");
  }
  result.first_tick = sides[0].get_tick();
  while (more[0] && more[1]) {
    ++result.compared;
    if (look) look(sides[0].get_tick());
    if (sides[0].get_hash() != sides[1].get_hash()) {
      result.state = build_difference(sides, simulations[0]->model());
      break;
    }
    note_first_input(sides, result.input);
    more = {sides[0].advance(), sides[1].advance()};
  }
  // Without a difference, one recording may be longer: its length and its end belong to the answer.
  for (std::size_t k = 0; k < 2; ++k) {
    while (more[k] && !result.state) more[k] = sides[k].advance();
    result.endings[k] = sides[k].get_ending();
  }
  return result;
}

}  // namespace unlatch::hil
