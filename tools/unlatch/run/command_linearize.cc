// unlatch linearize: the linear model about a state of a run, for the design of controllers.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "hil/run/linear/loop_margins.h"
#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/number_text.h"
#include "tools/common/matrix_files.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/run/verbs.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

struct LinearizeOptions {
  ScenarioOptions scenario;
  std::string at = "0";
  std::vector<std::string> inputs, outputs;
  std::vector<std::string> loops;
  double period = 0, delay = 0;  // s, of the loops
  std::string out, json;
};

constexpr double kDegree = std::numbers::pi / 180;

hil::LinearRequest read_request(const LinearizeOptions& options) {
  constexpr std::string_view kEvent = "event:";
  hil::LinearRequest request;
  request.inputs = options.inputs;
  request.outputs = options.outputs;
  if (options.at.starts_with(kEvent)) {
    request.event = options.at.substr(kEvent.size());
    if (request.event.empty()) refuse_option("--at", "'event:' is followed by the name of an event: event:release");
    return request;
  }
  try {
    const hil::Quantity time = hil::evaluate_expression(options.at, {});
    request.time = time.value;
    if (time.value >= 0 && (time.dimension.is_plain() || hil::dimension_of("s").takes(time.dimension))) return request;
  } catch (const hil::ExpressionError&) {  // refused below
  }
  refuse_option("--at", "'" + options.at + "' is neither a time, at least 0, such as 3, 3 s or 300 ms, nor event:NAME");
}

Json build_names(const std::vector<hil::LinearName>& names) {
  Json json = Json::array();
  for (const hil::LinearName& own : names) json.push_back({{"name", own.name}, {"unit", own.unit}});
  return json;
}

// Rows of numbers.
Json build_matrix(const Eigen::MatrixXd& matrix) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    const Eigen::RowVectorXd row = matrix.row(i);
    json.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return json;
}

Json build_margin(const std::optional<hil::LoopMargins::At>& margin) {
  return margin ? Json{{"value", margin->value}, {"at", margin->frequency}} : Json(nullptr);
}

struct Loop {
  std::string text;
  hil::LoopMargins margins;
};

Json build_json(const hil::Scenario& scenario, const hil::LinearSystem& system, const std::vector<Loop>& loops) {
  const LinearModel& model = system.model;
  Json json = {{"schema", 1},
               {"scenario", scenario.name},
               {"t", system.time},
               {"states", build_names(system.states)},
               {"inputs", build_names(system.inputs)},
               {"outputs", build_names(system.outputs)},
               {"A", build_matrix(model.A)},
               {"B", build_matrix(model.B)},
               {"C", build_matrix(model.C)},
               {"D", build_matrix(model.D)},
               {"A_error", build_matrix(model.A_error)},
               {"B_error", build_matrix(model.B_error)},
               {"C_error", build_matrix(model.C_error)},
               {"D_error", build_matrix(model.D_error)},
               {"accelerations", std::vector<double>(model.accelerations.begin(), model.accelerations.end())}};
  Json poles = Json::array(), poles_error = Json::array();
  for (const hil::Pole& pole : system.poles) {
    poles.push_back({pole.value.real(), pole.value.imag()});
    poles_error.push_back(pole.error);
  }
  json["poles"] = std::move(poles);
  json["poles_error"] = std::move(poles_error);
  json["gains"] = build_matrix(system.gains.values);  // JSON writes what is infinite as null
  json["gains_error"] = build_matrix(system.gains.errors);
  json["corners"] = model.corners;
  json["left_out"] = system.left_out;
  Json& list = json["loops"] = Json::array();
  for (const Loop& loop : loops)
    list.push_back({{"loop", loop.text},
                    {"stable", loop.margins.stable},
                    {"gain", build_margin(loop.margins.gain)},
                    {"drop", build_margin(loop.margins.drop)},
                    {"phase", build_margin(loop.margins.phase)},
                    {"delay", build_margin(loop.margins.delay)}});
  return json;
}

void write_file(const std::string& path, const hil::Scenario& scenario, const hil::LinearSystem& system,
                const std::vector<Loop>& loops) {
  if (path.empty()) return;
  const LinearModel& model = system.model;
  if (!path.ends_with(".mat") && !path.ends_with(".npz")) {
    write_json(build_json(scenario, system, loops), path);
    return;
  }
  std::vector<NamedMatrix> matrices{{"A", model.A},
                                    {"B", model.B},
                                    {"C", model.C},
                                    {"D", model.D},
                                    {"A_error", model.A_error},
                                    {"B_error", model.B_error},
                                    {"C_error", model.C_error},
                                    {"D_error", model.D_error},
                                    {"accelerations", model.accelerations},
                                    {"t", Eigen::MatrixXd::Constant(1, 1, system.time)}};
  Eigen::MatrixXd poles(std::ssize(system.poles), 2), poles_error(std::ssize(system.poles), 1);
  for (Eigen::Index i = 0; i < poles.rows(); ++i) {
    const hil::Pole& pole = system.poles[static_cast<std::size_t>(i)];
    poles.row(i) << pole.value.real(), pole.value.imag();
    poles_error(i) = pole.error;
  }
  matrices.push_back({"poles", std::move(poles)});
  matrices.push_back({"poles_error", std::move(poles_error)});
  matrices.push_back({"gains", system.gains.values});
  matrices.push_back({"gains_error", system.gains.errors});
  std::vector<NamedTexts> texts;
  const auto add = [&](const std::string& what, const std::vector<hil::LinearName>& names) {
    NamedTexts& own = texts.emplace_back(NamedTexts{what, {}});
    NamedTexts units{what.substr(0, what.size() - 1) + "_units", {}};
    for (const hil::LinearName& name : names) {
      own.texts.push_back(name.name);
      units.texts.push_back(name.unit);
    }
    texts.push_back(std::move(units));
  };
  add("states", system.states);
  add("inputs", system.inputs);
  add("outputs", system.outputs);
  write_text(path.ends_with(".mat") ? build_mat(matrices, texts) : build_npz(matrices, texts), path);
}

// Rows whose estimated errors are more than this of their largest entry are named.
constexpr double kPoor = 1e-4;

// Errors of a pair of matrices that share rows, (A B) or (C D), beside the largest entry of the row, whose entries have
// one unit but for that of their column. A row that is 0 but for rounding does not count.
void print_errors(std::FILE* out, const char* name, const std::vector<hil::LinearName>& rows,
                  const Eigen::MatrixXd& left, const Eigen::MatrixXd& left_error, const Eigen::MatrixXd& right,
                  const Eigen::MatrixXd& right_error) {
  const auto find_largest = [](const Eigen::RowVectorXd& row) {
    return row.size() > 0 ? row.cwiseAbs().maxCoeff() : 0;
  };
  double largest = 0;
  std::string poor;
  int count_poor = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double size = std::max(find_largest(left.row(row)), find_largest(right.row(row)));
    const double error = std::max(find_largest(left_error.row(row)), find_largest(right_error.row(row)));
    if (size <= error) continue;
    largest = std::max(largest, error / size);
    if (error > kPoor * size && ++count_poor <= 3)
      poor += (poor.empty() ? "" : ", ") + rows[i].name + " " + hil::write_short(error / size);
  }
  std::fprintf(out, "  %s %s%s%s%s\n", name, hil::write_short(largest).c_str(), poor.empty() ? "" : ": ", poor.c_str(),
               count_poor > 3 ? (" and " + count(count_poor - 3, "other")).c_str() : "");
}

void print_poles(std::FILE* out, const hil::LinearSystem& system) {
  int still = 0;
  double slowest = 0;  // 1/s: what is slower is not distinct from 0
  std::fprintf(out, "\npoles                          frequency      damping\n");
  for (const auto& [pole, error] : system.poles) {
    if (std::abs(pole) <= error) {
      ++still;
      slowest = std::max(slowest, std::abs(pole));
      continue;
    }
    if (pole.imag() < 0) continue;
    const double size = std::abs(pole);
    const std::string text = pole.imag() > 0 ? hil::write_short(drop_rounding(pole.real(), size * 1e3)) + " ± " +
                                                   hil::write_short(pole.imag()) + "i /s"
                                             : hil::write_short(pole.real()) + " /s";
    const std::string width(text.size() < 30 ? 30 - count_characters(text) : 1, ' ');
    std::fprintf(out, "%s%s %-9s Hz   %s\n", text.c_str(), width.c_str(),
                 hil::write_short(size / (2 * std::numbers::pi)).c_str(),
                 hil::write_short(drop_rounding(-pole.real() / size, 1e3)).c_str());
  }
  if (still > 0)
    std::fprintf(out, "%s at 0, to %s /s: free motions\n", count(still, "pole").c_str(),
                 hil::write_short(slowest).c_str());
}

// In the order of the model; gains that are not distinct from 0 are left out.
void print_gains(std::FILE* out, const hil::LinearSystem& system) {
  if (system.gains.values.size() == 0) return;
  constexpr int kMost = 40;
  std::fprintf(out, "\nsteady-state gains\n");
  int printed = 0, left = 0, endless = 0;
  for (std::size_t i = 0; i < system.inputs.size(); ++i)
    for (std::size_t k = 0; k < system.outputs.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k), column = static_cast<Eigen::Index>(i);
      const double gain = system.gains.values(row, column);
      if (std::isinf(gain)) {
        ++endless;
        continue;
      }
      if (std::abs(gain) <= system.gains.errors(row, column)) continue;  // not distinct from 0
      if (printed == kMost) {
        ++left;
        continue;
      }
      ++printed;
      std::fprintf(out, "  %-40s %s %s per %s\n", (system.inputs[i].name + " to " + system.outputs[k].name).c_str(),
                   hil::write_short(gain).c_str(), system.outputs[k].unit.c_str(), system.inputs[i].unit.c_str());
    }
  if (printed == 0) std::fprintf(out, "  none is distinct from 0\n");
  if (endless > 0)
    std::fprintf(out, "  %s without end, since an input moves the output by a free motion\n",
                 count(endless, "gain").c_str());
  if (left > 0) std::fprintf(out, "  %s: --json\n", count(left, "further gain").c_str());
}

void print_margin(std::FILE* out, const char* name, const std::optional<hil::LoopMargins::At>& margin, double unit,
                  const char* text) {
  if (margin)
    std::fprintf(out, "  %-14s %s %s at %s rad/s\n", name, hil::write_short(margin->value / unit).c_str(), text,
                 hil::write_short(margin->frequency).c_str());
}

void print(std::FILE* out, const hil::Scenario& scenario, const hil::LinearSystem& system,
           const std::vector<Loop>& loops) {
  const LinearModel& model = system.model;
  const std::size_t f = system.states.size() / 2;
  std::fprintf(out, "%s about t = %s s: %s, %s, %s\n\n", scenario.name.c_str(), hil::write_number(system.time).c_str(),
               count(static_cast<int>(f), "free coordinate").c_str(),
               count(static_cast<int>(system.inputs.size()), "input").c_str(),
               count(static_cast<int>(system.outputs.size()), "output").c_str());
  std::fprintf(out, "free coordinate                unit   acceleration now\n");
  for (std::size_t k = 0; k < f; ++k)
    std::fprintf(out, "%-30s %-6s %s\n", system.states[k].name.c_str(), system.states[k].unit.c_str(),
                 hil::write_short(drop_rounding(model.accelerations[static_cast<Eigen::Index>(k)], 1)).c_str());
  print_poles(out, system);
  print_gains(out, system);
  std::fprintf(out, "\nestimated errors beside the largest entry of a row, at most\n");
  print_errors(out, "A, B", system.states, model.A, model.A_error, model.B, model.B_error);
  print_errors(out, "C, D", system.outputs, model.C, model.C_error, model.D, model.D_error);
  if (model.accelerations.size() > 0 && model.accelerations.cwiseAbs().maxCoeff() > 1e-6)
    std::fprintf(
        out, "note: the state is no equilibrium; the model is of deviations from the motion that goes through it\n");
  for (const int corner : model.corners) {
    const auto k = static_cast<std::size_t>(corner);
    std::fprintf(out, "warning: forces have a corner along %s here; its column is the mean of both sides\n",
                 (k < system.states.size() ? system.states[k].name : "a channel").c_str());
  }
  for (const std::string& text : system.left_out) std::fprintf(out, "note: not in y: %s\n", text.c_str());
  if (!system.left_out.empty() && !loops.empty())
    std::fprintf(out, "note: --delay of a loop has to hold what its sensors are late\n");
  for (const Loop& loop : loops) {
    std::fprintf(
        out, "\nloop %s: closed alone, it is %s\n", loop.text.c_str(),
        loop.margins.stable ? "stable" : "UNSTABLE; what follows says where its number of unstable poles changes");
    const auto gain = loop.margins.gain, drop = loop.margins.drop;
    if (gain)
      std::fprintf(out, "  gain margin    %s (%s dB) at %s rad/s\n", hil::write_short(gain->value).c_str(),
                   hil::write_short(20 * std::log10(gain->value)).c_str(), hil::write_short(gain->frequency).c_str());
    if (drop)
      std::fprintf(out, "  gain reduction %s (%s dB) at %s rad/s\n", hil::write_short(drop->value).c_str(),
                   hil::write_short(20 * std::log10(drop->value)).c_str(), hil::write_short(drop->frequency).c_str());
    print_margin(out, "phase margin", loop.margins.phase, kDegree, "deg");
    print_margin(out, "delay margin", loop.margins.delay, 1, "s");
  }
}

int run(const LinearizeOptions& options) {
  check_output(options.json);
  check_output(options.out);
  const hil::LinearRequest request = read_request(options);
  const hil::Scenario scenario = load(options.scenario);
  try {
    const hil::LinearSystem system = hil::linearize(scenario, request);
    std::vector<Loop> loops;
    for (const std::string& text : options.loops) {
      hil::LoopRequest loop = hil::parse_loop(text);
      loop.period = options.period;
      loop.delay = options.delay;
      loops.push_back({text, hil::calc_margins(system, loop)});
    }
    print(get_people_stream(options.json), scenario, system, loops);
    write_file(options.out, scenario, system, loops);
    if (!options.json.empty()) write_json(build_json(scenario, system, loops), options.json);
    return kExitDone;
  } catch (const hil::LinearizationError& error) {
    std::fprintf(stderr, "%s: %s\n", options.scenario.path.c_str(), error.what());
    return kExitUsage;
  }
}

}  // namespace

void add_linearize(Command app, int& exit_code) {
  auto options = std::make_shared<LinearizeOptions>();
  Command command = app.add_verb(
      "linearize",
      "Linearises a scenario about a state of its run: dx/dt = A x + B u, y = C x + D u, with x the free coordinates "
      "of "
      "the present modes and their speeds, u the channels, y sensors and quantities. Prints the poles and the "
      "steady-state gains; with --loop the "
      "margins of a loop with sampling and delay.",
      "unlatch linearize hil/scenarios/array/scenario.yaml --at event:latch.panel2 --out array.mat\n"
      "unlatch linearize plant.yaml --inputs torque --outputs 'sensor.gyro.*' --loop 'torque=30*sensor.gyro.z' "
      "--period "
      "10ms --delay 20ms");
  add_scenario_options(command, options->scenario);
  command
      .add_option("--at", options->at,
                  "the state: a time, s or with its unit, moved to the nearest tick; or event:NAME or "
                  "event:NAME.SUBJECT, the end of the "
                  "step in which this event acts first (default: 0)")
      .type_name("TIME|event:NAME");
  command.add_option("--inputs", options->inputs, "channels, by name or pattern (default: all)")
      .type_name("NAME,...")
      .delimiter(',');
  command
      .add_option("--outputs", options->outputs,
                  "values of sensors and quantities, by name or pattern: sensor.gyro.x, quantity.* (default: all)")
      .type_name("NAME,...")
      .delimiter(',');
  command
      .add_option(
          "--loop", options->loops,
          "prints the margins of negative feedback: the channel is minus the sum of gain times output; repeatable, and "
          "each loop is closed alone, with the others open")
      .type_name("CHANNEL=GAIN*OUTPUT+...")
      .repeatable();
  command
      .add_option("--period", options->period,
                  "of the loops, s: outputs are sampled and the channel is held (default: continuous)")
      .seconds();
  command
      .add_option("--delay", options->delay,
                  "of the loops, s, from a sample to the command, a whole number of periods or not (default: 0)")
      .seconds(Seconds::kZeroToo);
  command
      .add_option("--out", options->out,
                  "writes matrices, names and units: FILE.mat (MATLAB), FILE.npz (NumPy), or JSON")
      .type_name("FILE");
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
