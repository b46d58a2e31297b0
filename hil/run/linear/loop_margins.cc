#include "hil/run/linear/loop_margins.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "hil/run/linear/matrices.h"
#include "hil/scenario/text/number_text.h"
#include "hil/scenario/text/suggestion.h"

namespace unlatch::hil {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::RowVectorXcd;
using Eigen::RowVectorXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using std::numbers::pi;

constexpr double kShortestPeriod = 1e-9;  // s
constexpr double kLeastGain = 1e-4;       // of |L|: crossings below it, or above its inverse, are left out

std::size_t find_name(const char* what, const std::string& name, const std::vector<LinearName>& names) {
  const auto found = std::ranges::find(names, name, &LinearName::name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::vector<std::string> all;
  for (const LinearName& other : names) all.push_back(other.name);
  throw LinearizationError("the linear model has no " + std::string(what) + " '" + name + "'; " + suggest(name, all));
}

// The loop's plant from its one input to its one sum of outputs: y = k x + direct u.
struct Plant {
  MatrixXd A;
  VectorXd b;
  RowVectorXd k;
  double direct = 0;
};

// The part of (A, b) that b reaches: in an orthogonal basis in which b is along the first axis and A is a Hessenberg
// matrix, as far as its subdiagonal goes on.
Index count_reached(Plant& plant) {
  constexpr double kLeastCoupling = 1e-9;  // beside the size of A and b
  const Index n = plant.A.rows();
  if (n == 0) return 0;
  MatrixXd both = MatrixXd::Zero(n + 1, n + 1);
  both.bottomLeftCorner(n, 1) = plant.b;
  both.bottomRightCorner(n, n) = plant.A;
  const auto [H, Q] = calc_hessenberg(both);
  plant.A = H.bottomRightCorner(n, n);
  plant.b = H.bottomLeftCorner(n, 1);
  plant.k = multiply_real(plant.k, Q.bottomRightCorner(n, n));
  const double size = std::max(plant.A.norm() / std::sqrt(static_cast<double>(n)), plant.b.norm());
  Index reached = plant.b.norm() > 0 ? 1 : 0;
  while (reached > 0 && reached < n && std::abs(plant.A(reached, reached - 1)) > kLeastCoupling * size) ++reached;
  return reached;
}

// Leaves out motions that the loop's input does not reach or its outputs do not see: they are not the loop's.
void reduce(Plant& plant) {
  for (int pass = 0; pass < 2; ++pass) {
    const Index reached = count_reached(plant);
    plant.A = plant.A.topLeftCorner(reached, reached).eval();
    plant.b = plant.b.head(reached).eval();
    plant.k = plant.k.head(reached).eval();
    // then the same of the dual system
    plant.A.transposeInPlace();
    const VectorXd b = plant.b;
    plant.b = plant.k.transpose();
    plant.k = b.transpose();
  }
}

// What an input that is held for `time` does: (∫ e^(As) ds) (A b), which is (e^(At) − 1, ∫ e^(As) ds b).
MatrixXd hold(const Plant& plant, double time) {
  const Index n = plant.A.rows();
  MatrixXd both = MatrixXd::Zero(2 * n, 2 * n);
  both.topLeftCorner(n, n) = plant.A * time;
  both.topRightCorner(n, n) = MatrixXd::Identity(n, n) * time;
  const MatrixXd grown = both.exp();
  MatrixXd right(n, n + 1);
  right << plant.A, plant.b;
  return multiply_real(grown.topRightCorner(n, n), right);
}

// One way of the command to the outputs, with its delay.
struct Path {
  VectorXcd b;
  double direct, delay;  // delay: s
};

// The open loop, in a basis in which A is triangular.
class OpenLoop {
 public:
  OpenLoop(const Plant& plant, double period, double delay) : period_(period), direct_(plant.direct) {
    MatrixXd A = plant.A;
    std::vector<std::pair<VectorXd, std::pair<double, double>>> paths;  // b; direct, delay
    if (period == 0) {
      paths.push_back({plant.b, {plant.direct, delay}});
    } else {
      const Index n = A.rows();
      double whole = std::floor(delay / period), rest = delay - whole * period;
      constexpr double kSame = 1e-9;  // of a period: a fraction that is rounding
      if (rest > (1 - kSame) * period) whole += 1, rest = 0;
      if (rest < kSame * period) rest = 0;
      const MatrixXd held = hold(plant, period) / period;
      const VectorXd newer = (rest == 0 ? held : hold(plant, period - rest) / period).rightCols(1);
      A = held.leftCols(n);
      paths.push_back({newer, {rest == 0 ? plant.direct : 0, whole * period}});
      if (rest > 0) paths.push_back({held.rightCols(1) - newer, {plant.direct, (whole + 1) * period}});
    }
    const SchurForm schur = calc_schur(A.cast<Complex>());
    T_ = schur.T;
    k_ = multiply(plant.k.cast<Complex>(), schur.U);
    double at_once = 0;
    VectorXd b_at_once = VectorXd::Zero(A.rows());
    for (const auto& [b, rest] : paths) {
      if (!b.allFinite()) break;
      paths_.push_back({multiply(schur.U.adjoint(), b.cast<Complex>()), rest.first, rest.second});
      at_once += rest.first;
      b_at_once += b;
    }
    if (paths_.size() < paths.size() || !T_.allFinite())
      throw LinearizationError("within one period of " + write_short(period) +
                               " s the plant grows beyond all numbers; take a shorter one");
    // Frequencies of the closed loop as if its delay were 0: where the resolution has to begin and to end.
    const MatrixXd closed = A - b_at_once * plant.k / (std::abs(1 + at_once) > 1e-6 ? 1 + at_once : 1);
    const VectorXcd closed_poles = calc_schur(closed.cast<Complex>()).T.diagonal();
    for (Index i = 0; i < T_.rows(); ++i) {
      sizes_.push_back(std::abs(T_(i, i)));
      sizes_.push_back(std::abs(closed_poles[i]));
    }
  }

  [[nodiscard]] Index size() const { return T_.rows(); }
  [[nodiscard]] double period() const { return period_; }
  [[nodiscard]] Complex pole(Index i) const { return T_(i, i); }  // of the plant, in δ
  [[nodiscard]] const std::vector<double>& sizes() const { return sizes_; }
  [[nodiscard]] double longest_delay() const { return paths_.back().delay; }
  // Part of the command that the outputs have at once.
  [[nodiscard]] double undelayed() const { return paths_.front().delay == 0 ? paths_.front().direct : 0; }
  [[nodiscard]] double direct() const { return direct_; }

  // δ at a frequency, rad/s.
  [[nodiscard]] Complex calc_delta(double w) const {
    if (period_ == 0) return {0, w};
    const double half = w * period_ / 2;
    return Complex(0, 2 * std::sin(half) / period_) * std::polar(1.0, half);
  }
  // L at a frequency, rad/s.
  [[nodiscard]] Complex calc(double w) const {
    const Complex delta = calc_delta(w);
    VectorXcd x = VectorXcd::Zero(size());
    Complex sum = 0;
    for (const Path& path : paths_) {
      const Complex late = std::polar(1.0, -w * path.delay);
      x += late * path.b;
      sum += late * path.direct;
    }
    for (Index i = size() - 1; i >= 0; --i) {
      x[i] /= delta - T_(i, i);
      for (Index j = 0; j < i; ++j) x[j] += T_(j, i) * x[i];
    }
    return (k_ * x)(0) + sum;
  }
  // Argument of Π(δ − λ) (1 + L), up to whole turns.
  [[nodiscard]] double calc_angle(double w, Complex open) const {
    const Complex delta = calc_delta(w);
    double angle = std::arg(1.0 + open);
    for (Index i = 0; i < size(); ++i) angle += std::arg(delta - T_(i, i));
    return angle;
  }

 private:
  double period_, direct_;  // s; 0: continuous
  MatrixXcd T_;
  RowVectorXcd k_;
  std::vector<Path> paths_;  // in ascending order of their delays
  std::vector<double> sizes_;
};

double wrap(double angle) { return std::remainder(angle, 2 * pi); }

struct Sample {
  double w;      // rad/s
  Complex open;  // L
  double angle;  // calc_angle()
};

Sample take(const OpenLoop& loop, double w) {
  const Complex open = loop.calc(w);
  return {w, open, loop.calc_angle(w, open)};
}

// Frequencies between which L changes by little, from where the closed loop's argument begins to change to where it
// ends.
std::vector<Sample> sample(const OpenLoop& loop) {
  constexpr int kPerDecade = 100;
  constexpr std::size_t kMost = 400000;
  double high = 0, low = std::numeric_limits<double>::infinity();
  for (const double size : loop.sizes()) high = std::max(high, size);
  if (high == 0) high = 1;
  for (const double size : loop.sizes())
    if (size > 1e-9 * high) low = std::min(low, size);
  if (loop.longest_delay() > 0) {
    low = std::min(low, 1 / loop.longest_delay());
    high = std::max(high, 1 / loop.longest_delay());
  }
  const double end = loop.period() > 0 ? pi / loop.period() : 1e4 * high;
  low = std::min(1e-3 * low, 1e-4 * end);
  // The argument begins at a multiple of π. Where it has not settled after these, a pole of the closed loop is at 0.
  for (int tries = 0; tries < 12; ++tries, low /= 10) {
    const double angle = take(loop, low).angle;
    if (std::abs(angle - pi * std::round(angle / pi)) < 0.01) break;
  }

  std::vector<double> grid;
  const int count = static_cast<int>(std::ceil(kPerDecade * std::log10(end / low))) + 1;
  for (int i = 0; i < count; ++i) grid.push_back(low * std::pow(end / low, static_cast<double>(i) / count));
  grid.push_back(end);
  for (Index i = 0; i < loop.size(); ++i) {  // closer about each resonance
    Complex pole = loop.pole(i);
    if (loop.period() > 0) pole = std::log(1.0 + loop.period() * pole) / loop.period();
    const double centre = std::abs(pole.imag());
    if (!(centre > low && centre < end)) continue;
    for (double off = std::max(std::abs(pole.real()), 1e-9 * centre) / 2; off < centre; off *= 3)
      for (const double w : {centre - off, centre + off})
        if (w > low && w < end) grid.push_back(w);
  }
  std::ranges::sort(grid);

  std::vector<Sample> samples{take(loop, grid.front())};
  std::vector<Sample> waiting;  // in descending order of their frequency
  for (std::size_t i = 1; i < grid.size(); ++i) {
    waiting.push_back(take(loop, grid[i]));
    while (!waiting.empty()) {
      const Sample &a = samples.back(), &b = waiting.back();
      const bool seen = std::max(std::abs(a.open), std::abs(b.open)) > kLeastGain;
      const bool coarse =
          std::abs(wrap(b.angle - a.angle)) > 0.5 ||
          (seen && (std::abs(std::arg(b.open * std::conj(a.open))) > 0.5 || (b.w - a.w) * loop.longest_delay() > 1 ||
                    std::abs(std::log(std::abs(b.open) / std::abs(a.open))) > 1));
      if (coarse && b.w > a.w * (1 + 1e-13)) {
        if (samples.size() + waiting.size() > kMost)
          throw LinearizationError("a loop with a delay of " + write_short(loop.longest_delay()) +
                                   " s is not resolved by " + write_number(static_cast<double>(kMost)) +
                                   " frequencies: the delay is too long beside the motion that the loop moves");
        waiting.push_back(take(loop, std::sqrt(a.w * b.w)));
      } else {
        samples.push_back(b);
        waiting.pop_back();
      }
    }
  }
  return samples;
}

bool is_stable(const OpenLoop& loop, const std::vector<Sample>& samples) {
  // What acts at once: an algebraic loop, or a command that returns enlarged after each delay.
  if (loop.undelayed() == 0 && std::abs(loop.direct()) >= 1) return false;
  const double first = samples.front().angle;
  double turned = first - pi * std::round(first / pi);
  for (std::size_t i = 1; i < samples.size(); ++i) turned += wrap(samples[i].angle - samples[i - 1].angle);
  const double whole = static_cast<double>(loop.size()) * (loop.period() > 0 ? pi : pi / 2);
  return std::abs(turned - whole) < pi / 2;
}

// The least delay beside the loop's own with which a stable sampled loop no longer is, s; `estimate`: that by the
// phase, as if a delay did nothing but turn it. Between samples a delay also moves the command's hold, so that it is
// searched for: in eighths of the estimate up to twice it, then by bisection. None if the loop stays stable up to
// there.
std::optional<double> find_delay_margin(const Plant& plant, const LoopRequest& request, double estimate) {
  constexpr int kParts = 8, kBisections = 40;
  const auto stays = [&](double more) {
    const OpenLoop loop(plant, request.period, request.delay + more);
    return is_stable(loop, sample(loop));
  };
  double low = 0, high = 0;
  for (int i = 1; high == 0 && i <= 2 * kParts; ++i) {
    const double more = estimate * i / kParts;
    (stays(more) ? low : high) = more;
  }
  if (high == 0) return {};
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (stays(middle) ? low : high) = middle;
  }
  return low;
}

// A crossing between two frequencies, to its last bits; nothing if the function jumps there.
template <class Function>
std::optional<double> find_zero(const OpenLoop& loop, double low, double high, const Function& function) {
  const bool negative = std::signbit(function(loop.calc(low)));
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (std::signbit(function(loop.calc(middle))) == negative ? low : high) = middle;
  }
  const Complex before = loop.calc(low), after = loop.calc(high);
  if (std::abs(after - before) > 0.1 * std::abs(after)) return {};
  return std::sqrt(low * high);
}

}  // namespace

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
    if (error == std::errc::result_out_of_range || (error == std::errc() && !std::isfinite(gain)))
      throw refuse("a gain is too large or too small for a number");
    if (error != std::errc()) throw refuse("a term has no gain");
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

LoopMargins calc_margins(const LinearSystem& system, const LoopRequest& request) {
  if (request.period != 0 && !(request.period >= kShortestPeriod && std::isfinite(request.period)))
    throw LinearizationError("a period of " + write_short(request.period) +
                             " s: it is at least 1e-9 s, or 0 for a continuous loop");
  if (!(request.delay >= 0 && std::isfinite(request.delay)))
    throw LinearizationError("a delay of " + write_short(request.delay) + " s: it is at least 0");
  const std::size_t input = find_name("channel", request.input, system.inputs);
  Plant plant{system.model.A, system.model.B.col(static_cast<Index>(input)), RowVectorXd::Zero(system.model.A.cols())};
  for (const LoopRequest::Term& term : request.terms) {
    const auto output = static_cast<Index>(find_name("output", term.output, system.outputs));
    plant.k += term.gain * system.model.C.row(output);
    plant.direct += term.gain * system.model.D(output, static_cast<Index>(input));
  }
  reduce(plant);
  if (plant.A.rows() == 0) throw LinearizationError("'" + request.input + "' moves none of the outputs of its loop");
  const OpenLoop loop(plant, request.period, request.delay);
  const std::vector<Sample> samples = sample(loop);

  LoopMargins margins;
  margins.stable = is_stable(loop, samples);
  const auto keep_least = [](std::optional<LoopMargins::At>& kept, double value, double frequency, bool least) {
    if (!kept || (least ? value < kept->value : value > kept->value)) kept = LoopMargins::At{value, frequency};
  };
  const auto add_real = [&](double open, double w) {  // L where it is real
    if (open >= -kLeastGain || open <= -1 / kLeastGain) return;
    if (open >= -1)
      keep_least(margins.gain, -1 / open, w, true);
    else
      keep_least(margins.drop, -1 / open, w, false);
  };
  const auto calc_excess = [](Complex open) { return std::abs(open) - 1; };
  const auto calc_phase = [](Complex open) { return std::arg(-open); };  // from −1
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Sample &a = samples[i - 1], &b = samples[i];
    if (std::signbit(calc_excess(a.open)) != std::signbit(calc_excess(b.open))) {
      if (const std::optional<double> w = find_zero(loop, a.w, b.w, calc_excess)) {
        const double phase = calc_phase(loop.calc(*w));
        keep_least(margins.phase, std::abs(phase), *w, true);
        keep_least(margins.delay, (phase >= 0 ? phase : phase + 2 * pi) / *w, *w, true);
      }
    }
    if (std::signbit(calc_phase(a.open)) != std::signbit(calc_phase(b.open)) && b.open.real() < 0)
      if (const std::optional<double> w = find_zero(loop, a.w, b.w, calc_phase)) add_real(loop.calc(*w).real(), *w);
  }
  if (request.period > 0 && margins.stable && margins.delay) {
    const std::optional<double> delay = find_delay_margin(plant, request, margins.delay->value);
    margins.delay = delay ? std::optional(LoopMargins::At{*delay, margins.delay->frequency}) : std::nullopt;
  }
  // The two ends, where L is real. At 0 it has a value if no pole is there.
  double free = 0;
  for (const Pole& pole : system.poles)
    if (pole.is_at_zero()) free = std::max(free, pole.error);
  bool decided = true;
  for (Index i = 0; i < loop.size(); ++i) decided = decided && std::abs(loop.pole(i)) > free;
  if (decided) add_real(loop.calc(0).real(), 0);
  if (request.period > 0)
    add_real(samples.back().open.real(), samples.back().w);
  else if (request.delay == 0)
    add_real(loop.direct(), std::numeric_limits<double>::infinity());
  return margins;
}

}  // namespace unlatch::hil
