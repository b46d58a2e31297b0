#include "hil/run/linearization.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "hil/run/run.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/text/number_text.h"
#include "hil/scenario/text/suggestion.h"
#include "unlatch/contacts.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

constexpr const char* kAxes[] = {"x", "y", "z"};

LinearName name_coordinate(const Model& model, const LinearCoordinate& own) {
  const auto subject = static_cast<std::size_t>(own.subject);
  switch (own.kind) {
    case LinearCoordinate::Kind::kPosition:
      return {"body." + model.bodies[subject].name + "." + kAxes[own.axis], "m"};
    case LinearCoordinate::Kind::kAttitude:
      return {"body." + model.bodies[subject].name + ".rot_" + kAxes[own.axis], "rad"};
    case LinearCoordinate::Kind::kModal:
      return {"body." + model.bodies[subject].name + ".modal." + std::to_string(own.axis + 1), "1"};
    case LinearCoordinate::Kind::kJoint:
      break;
  }
  return {"joint." + model.joints[subject].name + "." + kRowNames[own.axis], own.axis < kRotX ? "m" : "rad"};
}

std::string get_rate_unit(const std::string& unit) { return unit == "1" ? "1/s" : unit + "/s"; }

// All values of sensors and quantities that may be outputs, in the order of the model.
struct Value {
  LinearName name;
  bool sensor;
  int index;  // into Workspace::sensors or Workspace::quantities
};
std::vector<Value> list_values(const Scenario& scenario) {
  std::vector<Value> values;
  int sensors = 0;
  for (const Output& output : list_outputs(scenario)) {
    if (output.kind == Output::Kind::kSensor)
      for (const Output::Column& column : output.columns)
        values.push_back({{column.name, column.unit}, true, sensors++});
    if (output.kind == Output::Kind::kQuantity)
      for (const Output::Column& column : output.columns)
        values.push_back({{column.name, column.unit}, false, output.subject});
  }
  return values;
}

bool matches_name(const std::string& pattern, const std::string& name) {
  Output output;
  output.name = name;
  return matches(pattern, output);
}

// Numbers of the names that a pattern selects, in the order of the patterns, each once; all without a pattern.
std::vector<std::size_t> choose(const char* what, const std::vector<std::string>& patterns,
                                const std::vector<LinearName>& names) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; patterns.empty() && i < names.size(); ++i) chosen.push_back(i);
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!matches_name(pattern, names[i].name)) continue;
      any = true;
      if (std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
    }
    if (any) continue;
    std::string list;
    for (const LinearName& name : names) list += (list.empty() ? "" : ", ") + name.name;
    throw LinearizationError("there is no " + std::string(what) + " '" + pattern + "'" +
                             (list.empty() ? "; the scenario has none" : "; there are: " + list));
  }
  return chosen;
}

// Runs up to the state that the request names.
void advance(const Scenario& scenario, const LinearRequest& request, Simulation& simulation) {
  const Model& model = simulation.model();
  const std::int64_t last = calc_nearest_tick(request.event.empty() ? request.time : scenario.until, scenario.dt);
  const auto is_it = [&](const FiredEvent& fired) {
    const Event& event = model.events[static_cast<std::size_t>(fired.event)];
    return event.name == request.event || event.name + "." + event.subject == request.event;
  };
  if (!request.event.empty() && std::ranges::none_of(model.events, [&](const Event& event) {
        return event.name == request.event || event.name + "." + event.subject == request.event;
      })) {
    std::vector<std::string> names;
    for (const Event& event : model.events) names.push_back(event.name);
    throw LinearizationError("there is no event '" + request.event + "'" + suggest(request.event, names));
  }
  if (request.event.empty() && request.time > scenario.until)
    throw LinearizationError("t = " + write_short(request.time) + " s is after the end of the run, " +
                             write_short(scenario.until) + " s; --until moves it");
  while (simulation.get_tick() < last) {
    const StepReport report = simulation.step();
    if (report.status != StepStatus::kOk)
      throw LinearizationError("the run ended at t = " + write_short(simulation.get_time()) +
                               " s: " + get_status_text(report.status));
    if (!request.event.empty() && std::ranges::any_of(report.events, is_it)) return;
  }
  if (!request.event.empty())
    throw LinearizationError("event '" + request.event + "' did not act before the end of the run, t = " +
                             write_short(simulation.get_time()) + " s");
}

// Keeps these columns of a matrix.
MatrixXd keep_columns(const MatrixXd& all, const std::vector<std::size_t>& columns) {
  MatrixXd kept(all.rows(), std::ssize(columns));
  for (Index k = 0; k < kept.cols(); ++k)
    kept.col(k) = all.col(static_cast<Index>(columns[static_cast<std::size_t>(k)]));
  return kept;
}

std::vector<LinearName> pick(const std::vector<LinearName>& names, const std::vector<std::size_t>& chosen) {
  std::vector<LinearName> out;
  for (const std::size_t i : chosen) out.push_back(names[i]);
  return out;
}

}  // namespace

LinearSystem linearize(const Scenario& scenario, const LinearRequest& request) {
  const auto simulation = build_simulation(scenario);
  advance(scenario, request, *simulation);
  return linearize(scenario, *simulation, request);
}

namespace {

// A closed rigid contact is no spring: small motions into it do not exist, and those away from it open it.
void refuse_rigid_contacts(const Model& model, const Simulation& simulation) {
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    if (!model.contacts[i].rigid) continue;
    for (const ContactState& pair : get_contact_pairs(simulation.plan(), simulation.state(), static_cast<int>(i)))
      if (pair.closed != 0)
        throw LinearizationError("the rigid contact '" + model.contacts[i].name +
                                 "' is closed at t = " + write_short(simulation.get_time()) +
                                 " s: a linear model has no force on one side; give it a stiffness, or switch it off");
  }
}

}  // namespace

LinearSystem linearize(const Scenario& scenario, const Simulation& simulation, const LinearRequest& request) {
  const Model& model = scenario.model;
  refuse_rigid_contacts(model, simulation);
  const std::vector<Value> values = list_values(scenario);
  std::vector<LinearName> channels, names;
  for (const Channel& channel : model.channels) channels.push_back({channel.name, channel.unit});
  for (const Value& value : values) names.push_back(value.name);
  const std::vector<std::size_t> inputs = choose("channel", request.inputs, channels);
  const std::vector<std::size_t> outputs = choose("sensor or quantity", request.outputs, names);

  // Sensors come first in the kernel's model; the order of the request comes after.
  LinearOutputs wanted;
  std::vector<std::size_t> places(outputs.size());
  for (const bool sensor : {true, false})
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const Value& value = values[outputs[i]];
      if (value.sensor != sensor) continue;
      places[i] = wanted.sensors.size() + wanted.quantities.size();
      (sensor ? wanted.sensors : wanted.quantities).push_back(value.index);
    }
  std::optional<LinearModel> linear =
      calc_linear_model(simulation.plan(), simulation.state(), simulation.get_inputs(), wanted);
  if (!linear)
    throw LinearizationError("a pivot vanishes at t = " + write_short(simulation.get_time()) +
                             " s: the joints hold no definite set of freedoms there");

  LinearSystem system;
  system.time = simulation.get_time();
  for (const LinearCoordinate& own : linear->coordinates) system.states.push_back(name_coordinate(model, own));
  for (std::size_t k = 0, f = system.states.size(); k < f; ++k) {
    const LinearName own = system.states[k];
    system.states.push_back({"rate." + own.name, get_rate_unit(own.unit)});
  }
  system.inputs = pick(channels, inputs);
  system.outputs = pick(names, outputs);
  for (MatrixXd* const matrix : {&linear->B, &linear->B_error, &linear->D, &linear->D_error})
    *matrix = keep_columns(*matrix, inputs);
  for (MatrixXd* const matrix : {&linear->C, &linear->C_error, &linear->D, &linear->D_error})
    *matrix = keep_columns(matrix->transpose(), places).transpose();
  const Index states = linear->A.rows();
  if (states > 0) {
    const Eigen::VectorXcd poles = linear->A.eigenvalues();
    system.poles.assign(poles.begin(), poles.end());
    // m equal poles are computed as a ring of radius (error of A)^(1/m); three and four at 0 are the usual free motions
    system.pole_rounding = std::cbrt(linear->A_error.cwiseAbs().maxCoeff() + 1e-16 * linear->A.cwiseAbs().maxCoeff());
    std::ranges::sort(system.poles, [](const Complex& a, const Complex& b) {
      return std::pair(std::abs(a), a.imag()) < std::pair(std::abs(b), b.imag());
    });
  }
  const auto moving =
      std::ranges::find_if(system.poles, [&](const Complex& pole) { return std::abs(pole) > system.pole_rounding; });
  system.gains =
      calc_steady_gains(*linear, moving - system.poles.begin(), moving != system.poles.end() ? std::abs(*moving) : 0);
  system.model = std::move(*linear);
  return system;
}

LoopRequest parse_loop(const std::string& text) {
  const auto refuse = [&](const std::string& why) {
    return LinearizationError(
        "'" + text + "': " + why +
        "; a loop is written CHANNEL=GAIN*OUTPUT+GAIN*OUTPUT, for example torque=12*sensor.angle+30*sensor.gyro.z");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw refuse("it names no channel");
  LoopRequest loop;
  const auto trim = [](std::string part) {
    const auto first = part.find_first_not_of(' '), last = part.find_last_not_of(' ');
    return first == std::string::npos ? std::string() : part.substr(first, last - first + 1);
  };
  loop.input = trim(text.substr(0, equals));
  std::size_t at = equals + 1;
  while (at < text.size()) {
    while (at < text.size() && text[at] == ' ') ++at;
    double sign = 1;
    while (at < text.size() && (text[at] == '+' || text[at] == '-' || text[at] == ' ')) {
      if (text[at] == '-') sign = -sign;
      ++at;
    }
    double gain = 0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), gain);
    if (error != std::errc() || !std::isfinite(gain)) throw refuse("a term has no gain");
    at = static_cast<std::size_t>(end - text.data());
    while (at < text.size() && text[at] == ' ') ++at;
    if (at == text.size() || text[at] != '*') throw refuse("a gain has no '*' behind it");
    const std::size_t stop = text.find_first_of("+-", at + 1);
    loop.terms.push_back({sign * gain, trim(text.substr(at + 1, stop == std::string::npos ? stop : stop - at - 1))});
    if (loop.terms.back().output.empty()) throw refuse("a gain has no output");
    at = stop == std::string::npos ? text.size() : stop;
  }
  if (loop.terms.empty()) throw refuse("it has no term");
  return loop;
}

namespace {

std::size_t find_name(const char* what, const std::string& name, const std::vector<LinearName>& names) {
  const auto found = std::ranges::find(names, name, &LinearName::name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::vector<std::string> all;
  for (const LinearName& other : names) all.push_back(other.name);
  throw LinearizationError("the linear model has no " + std::string(what) + " '" + name + "'" + suggest(name, all));
}

// The open loop from the input to what the loop makes of it, with the sign of negative feedback.
struct OpenLoop {
  MatrixXd A;
  Eigen::VectorXd b;
  Eigen::RowVectorXd k;
  double direct;
  double period;      // s; 0: continuous
  double delay;       // s
  std::int64_t late;  // delay in periods

  Complex calc(double frequency) const {
    const Complex s(0, frequency);
    const Complex z = period > 0 ? std::exp(s * period) : s;
    const MatrixXcd pencil = z * MatrixXcd::Identity(A.rows(), A.cols()) - A.cast<Complex>();
    const Complex plant = (k.cast<Complex>() * pencil.partialPivLu().solve(b.cast<Complex>()))(0) + direct;
    return plant * std::exp(-s * (period > 0 ? static_cast<double>(late) * period : delay));
  }
  // With the delay as a chain of held values, or of a continuous loop as a Padé approximation of the second order.
  bool is_stable_closed() const {
    const Index n = A.rows();
    if (period > 0) {
      MatrixXd closed = MatrixXd::Zero(n + late, n + late);
      closed.topLeftCorner(n, n) = A;
      if (late == 0) {
        closed -= b * k / (1 + direct);
      } else {
        closed.block(0, n + late - 1, n, 1) = b;
        closed.block(n, 0, 1, n) = -k;
        closed(n, n + late - 1) -= direct;
        for (Index i = 1; i < late; ++i) closed(n + i, n + i - 1) = 1;
      }
      return closed.eigenvalues().cwiseAbs().maxCoeff() < 1;
    }
    if (delay == 0) return (A - b * k / (1 + direct)).eigenvalues().real().maxCoeff() < 0;
    // e^-sd ≈ 1 − (12/d) s / (s² + 6/d s + 12/d²): states p with p'' = … driven by v = −k x − direct u
    const double d = delay;
    MatrixXd closed = MatrixXd::Zero(n + 2, n + 2);
    Eigen::RowVectorXd v = Eigen::RowVectorXd::Zero(n + 2), u = v;
    // u = v + p2, v = −k x − direct u
    v.head(n) = -k / (1 + direct);
    v[n + 1] = -direct / (1 + direct);
    u = v;
    u[n + 1] += 1;
    closed.topLeftCorner(n, n) = A;
    closed.topRows(n) += b * u;
    closed.row(n)[n + 1] += 1;  // p1' = p2
    closed.row(n + 1) += -12 / d * v;
    closed.row(n + 1)[n] += -12 / (d * d);
    closed.row(n + 1)[n + 1] += -6 / d;
    return closed.eigenvalues().real().maxCoeff() < 0;
  }
};

// The part of (A, b) that b reaches: in an orthogonal basis in which b is along the first axis and A is a Hessenberg
// matrix, as far as its subdiagonal goes on.
Index count_reached(MatrixXd& A, Eigen::VectorXd& b, Eigen::RowVectorXd& k) {
  constexpr double kLeastCoupling = 1e-9;  // beside the size of A and b
  const Index n = A.rows();
  MatrixXd both = MatrixXd::Zero(n + 1, n + 1);
  both.bottomLeftCorner(n, 1) = b;
  both.bottomRightCorner(n, n) = A;
  const Eigen::HessenbergDecomposition<MatrixXd> reduced(both);
  const MatrixXd H = reduced.matrixH(), Q = reduced.matrixQ();
  A = H.bottomRightCorner(n, n);
  b = H.bottomLeftCorner(n, 1);
  k = (k * Q.bottomRightCorner(n, n)).eval();
  const double size = std::max(A.norm() / std::sqrt(static_cast<double>(n)), b.norm());
  Index reached = b.norm() > 0 ? 1 : 0;
  while (reached > 0 && reached < n && std::abs(A(reached, reached - 1)) > kLeastCoupling * size) ++reached;
  return reached;
}

// Leaves out motions that the loop's input does not reach or its outputs do not see: they are not the loop's.
void reduce(OpenLoop& loop) {
  for (int pass = 0; pass < 2; ++pass) {
    const Index reached = count_reached(loop.A, loop.b, loop.k);
    loop.A = loop.A.topLeftCorner(reached, reached).eval();
    loop.b = loop.b.head(reached).eval();
    loop.k = loop.k.head(reached).eval();
    // then the same of the dual system
    loop.A.transposeInPlace();
    const Eigen::VectorXd b = loop.b;
    loop.b = loop.k.transpose();
    loop.k = b.transpose();
  }
}

// Frequencies at which a function of the frequency changes its sign, to its last bits.
std::vector<double> find_zeros(const std::vector<double>& frequencies, const std::function<double(double)>& function) {
  std::vector<double> zeros;
  double low = frequencies.front(), at_low = function(low);
  for (const double next : frequencies) {
    double high = next, at_high = function(high);
    if (std::signbit(at_low) != std::signbit(at_high)) {
      double a = low, b = high;
      for (int i = 0; i < 60; ++i) {
        const double middle = std::sqrt(a * b);
        (std::signbit(function(middle)) == std::signbit(at_low) ? a : b) = middle;
      }
      zeros.push_back(std::sqrt(a * b));
    }
    low = high;
    at_low = at_high;
  }
  return zeros;
}

}  // namespace

LoopMargins calc_margins(const LinearSystem& system, const LoopRequest& request) {
  const std::size_t input = find_name("channel", request.input, system.inputs);
  OpenLoop loop;
  loop.A = system.model.A;
  loop.b = system.model.B.col(static_cast<Index>(input));
  loop.k = Eigen::RowVectorXd::Zero(loop.A.cols());
  loop.direct = 0;
  for (const LoopRequest::Term& term : request.terms) {
    const auto output = static_cast<Index>(find_name("output", term.output, system.outputs));
    loop.k += term.gain * system.model.C.row(output);
    loop.direct += term.gain * system.model.D(output, static_cast<Index>(input));
  }
  loop.period = request.period;
  loop.delay = request.delay;
  loop.late = 0;
  reduce(loop);
  const Index n = loop.A.rows();
  if (n == 0) throw LinearizationError("'" + request.input + "' moves none of the outputs of its loop");
  if (request.period > 0) {
    const double periods = request.delay / request.period;
    loop.late = std::llround(periods);
    if (std::abs(periods - static_cast<double>(loop.late)) > 1e-9 * std::max(1.0, periods))
      throw LinearizationError("a delay of " + write_number(request.delay) + " s is no whole number of periods of " +
                               write_number(request.period) + " s");
    MatrixXd both = MatrixXd::Zero(n + 1, n + 1);  // held input: exp of (A b; 0 0) T
    both.topLeftCorner(n, n) = loop.A;
    both.topRightCorner(n, 1) = loop.b;
    const MatrixXd held = (both * request.period).exp();
    loop.A = held.topLeftCorner(n, n);
    loop.b = held.topRightCorner(n, 1);
  }

  constexpr int kFrequencies = 4000;
  double top = 1e3;
  for (const Complex& pole : system.poles) top = std::max(top, 100 * std::abs(pole));
  if (request.period > 0) top = 0.999999 * std::numbers::pi / request.period;
  const double bottom = top * 1e-8;
  std::vector<double> frequencies(kFrequencies);
  for (int i = 0; i < kFrequencies; ++i)
    frequencies[static_cast<std::size_t>(i)] =
        bottom * std::pow(top / bottom, static_cast<double>(i) / (kFrequencies - 1));

  LoopMargins margins;
  margins.stable = loop.is_stable_closed();
  const auto keep_least = [](std::optional<LoopMargins::At>& kept, double value, double frequency, bool least) {
    if (!kept || (least ? value < kept->value : value > kept->value)) kept = LoopMargins::At{value, frequency};
  };
  for (const double w : find_zeros(frequencies, [&](double w) { return std::abs(loop.calc(w)) - 1; })) {
    const double phase = std::arg(-loop.calc(w));  // from −1
    keep_least(margins.phase, std::abs(phase), w, true);
    const double late = (phase >= 0 ? phase : phase + 2 * std::numbers::pi) / w;
    keep_least(margins.delay, late, w, true);
  }
  for (const double w : find_zeros(frequencies, [&](double w) { return std::arg(-loop.calc(w)); })) {
    const Complex value = loop.calc(w);
    if (value.real() >= 0) continue;  // a jump of the phase, far from −1
    const double factor = 1 / std::abs(value);
    if (factor >= 1)
      keep_least(margins.gain, factor, w, true);
    else
      keep_least(margins.drop, factor, w, false);
  }
  return margins;
}

}  // namespace unlatch::hil
