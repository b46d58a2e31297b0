#include "kernel/events/cone_impulses.h"

#include <algorithm>
#include <cmath>

#include "kernel/solver/dense_ldl.h"

namespace unlatch {
namespace {

// x and y, see cone_impulses.h: the impulses that a pair would have next, before they are brought into its cone.
struct Aim {
  double normal, first, second;
  double per_normal, per_side;  // 1/m_n, 1/m_t
};

// What row r has beyond its load, with the yield.
double calc_yielding_rate(const RigidScratch& s, std::span<const double> p, int r) {
  const double* row = &s.matrix[at(r) * s.loads.size()];
  double sum = s.yield * get_pair_mobility(s, r) * p[at(r)] - s.loads[at(r)];
  for (int c = 0; c < s.count; ++c) sum += row[c] * p[at(c)];
  return sum;
}

bool has_sides(const RigidScratch& s, int r) { return r + 1 < s.count && s.rows[at(r + 1)].tangent != 0; }

double invert(double mobility, double free) {
  constexpr double kLeast = 1e-9;  // of the free mobility: what is held by joints
  return 1 / std::max(mobility, kLeast * free);
}

Aim calc_aim(const RigidScratch& s, std::span<const double> p, int r) {
  const std::size_t n = s.loads.size();
  const auto own = [&](int i) { return s.matrix[at(i) * n + at(i)]; };
  Aim aim{};
  aim.per_normal = invert(own(r), s.rows[at(r)].free);
  aim.normal = p[at(r)] - aim.per_normal * calc_yielding_rate(s, p, r);
  if (!has_sides(s, r)) return aim;
  aim.per_side = invert(0.5 * (own(r + 1) + own(r + 2)), s.rows[at(r + 1)].free);
  aim.first = p[at(r + 1)] - aim.per_side * calc_yielding_rate(s, p, r + 1);
  aim.second = p[at(r + 2)] - aim.per_side * calc_yielding_rate(s, p, r + 2);
  return aim;
}

// The residual of all rows, m/s; returns its size.
double calc_residual(const RigidScratch& s, Slips slips, std::span<const double> p, std::span<double> residual) {
  double square = 0;
  for (int r = 0; r < s.count; ++r) {
    if (s.rows[at(r)].tangent != 0) continue;
    const Aim aim = calc_aim(s, p, r);
    const double unit = get_pair_mobility(s, r), normal = std::max(0.0, aim.normal);
    residual[at(r)] = unit * (p[at(r)] - normal);
    if (has_sides(s, r) && is_directed(s, r, slips)) {
      const RigidRow& row = s.rows[at(r)];
      for (int k = 0; k < 2; ++k)
        residual[at(r + 1 + k)] = unit * (p[at(r + 1 + k)] + row.friction * normal * row.slide[k]);
    } else if (has_sides(s, r)) {
      const double most = s.rows[at(r)].friction * normal;
      const double size = std::sqrt(aim.first * aim.first + aim.second * aim.second);
      const double part = size <= most ? 1 : most / size;
      residual[at(r + 1)] = unit * (p[at(r + 1)] - part * aim.first);
      residual[at(r + 2)] = unit * (p[at(r + 2)] - part * aim.second);
    }
  }
  for (int r = 0; r < s.count; ++r) square += residual[at(r)] * residual[at(r)];
  return std::sqrt(square);
}

// Derivative of one of a pair's aims: weights of its own impulse and of the rates of its rows.
struct Weights {
  double on_normal, on_first, on_second;        // of the impulses
  double rate_normal, rate_first, rate_second;  // of the rates
};

void set_row(RigidScratch& s, int of, int r, const Weights& w) {
  const std::size_t n = s.loads.size();
  const double unit = get_pair_mobility(s, r);
  double* const row = &s.factor[at(of) * n];
  const double* const normal = &s.matrix[at(r) * n];
  const bool sides = has_sides(s, r);
  for (int c = 0; c < s.count; ++c) {
    double sum = w.rate_normal * normal[c];
    if (sides) sum += w.rate_first * normal[n + at(c)] + w.rate_second * normal[2 * n + at(c)];
    row[c] = sum * (unit / get_pair_mobility(s, c));
  }
  row[r] += w.on_normal + s.yield * unit * w.rate_normal;
  if (!sides) return;
  row[r + 1] += w.on_first + s.yield * unit * w.rate_first;
  row[r + 2] += w.on_second + s.yield * unit * w.rate_second;
}

// The derivative of the residual by p times the mobilities, in s.factor.
void update_derivative(Slips slips, RigidScratch& s) {
  for (int r = 0; r < s.count; ++r) {
    if (s.rows[at(r)].tangent != 0) continue;
    const Aim aim = calc_aim(s, s.forces, r);
    const bool presses = aim.normal > 0;
    set_row(s, r, r, {presses ? 0.0 : 1.0, 0, 0, presses ? aim.per_normal : 0.0, 0, 0});
    if (!has_sides(s, r)) continue;
    if (is_directed(s, r, slips)) {
      const RigidRow& row = s.rows[at(r)];
      const double per = presses ? row.friction * aim.per_normal : 0, part = presses ? row.friction : 0;
      set_row(s, r + 1, r, {part * row.slide[0], 1, 0, -per * row.slide[0], 0, 0});
      set_row(s, r + 2, r, {part * row.slide[1], 0, 1, -per * row.slide[1], 0, 0});
      continue;
    }
    const double most = s.rows[at(r)].friction * std::max(0.0, aim.normal);
    const double size = std::sqrt(aim.first * aim.first + aim.second * aim.second);
    if (size <= most) {
      set_row(s, r + 1, r, {0, 0, 0, 0, aim.per_side, 0});
      set_row(s, r + 2, r, {0, 0, 0, 0, 0, aim.per_side});
    } else if (!(most > 0)) {
      set_row(s, r + 1, r, {0, 1, 0, 0, 0, 0});
      set_row(s, r + 2, r, {0, 0, 1, 0, 0, 0});
    } else {
      const double x = aim.first / size, y = aim.second / size, part = most / size, mu = s.rows[at(r)].friction;
      const double xx = part * y * y, xy = -part * x * y, yy = part * x * x;  // of the aim's sides
      const double along = aim.per_normal * mu, across = aim.per_side;
      set_row(s, r + 1, r, {-mu * x, 1 - xx, -xy, along * x, across * xx, across * xy});
      set_row(s, r + 2, r, {-mu * y, -xy, 1 - yy, along * y, across * xy, across * yy});
    }
  }
}

// p + d in s.trial, for a λ; `residual`: that at s.forces.
bool set_trial(double lambda, std::span<const double> residual, RigidScratch& s) {
  const std::size_t n = s.loads.size();
  const LowerTriangle gram{s.gram.data(), static_cast<std::int32_t>(n)};
  for (int k = 0; k < s.count; ++k)
    for (int m = 0; m <= k; ++m) {
      double sum = k == m ? lambda : 0;
      for (int r = 0; r < s.count; ++r) sum += s.factor[at(r) * n + at(k)] * s.factor[at(r) * n + at(m)];
      gram(k, m) = sum;
    }
  for (int k = 0; k < s.count; ++k) {
    double sum = 0;
    for (int r = 0; r < s.count; ++r) sum -= s.factor[at(r) * n + at(k)] * residual[at(r)];
    s.trial[at(k)] = sum;
  }
  if (!factor_ldl(gram, s.count)) return false;
  solve_ldl(gram, s.count, s.trial.data());
  for (int k = 0; k < s.count; ++k) s.trial[at(k)] = s.forces[at(k)] + s.trial[at(k)] / get_pair_mobility(s, k);
  return true;
}

}  // namespace

double get_pair_mobility(const RigidScratch& s, int r) noexcept {
  const int own = r - s.rows[at(r)].tangent;
  constexpr double kLeast = 1e-9;  // of the free mobility: what is held by joints
  return std::max(s.matrix[at(own) * s.loads.size() + at(own)], kLeast * s.rows[at(own)].free);
}

double improve_cone_impulses(double fastest, Slips slips, RigidScratch& s) noexcept {
  constexpr double kEnough = 1e-12, kLeast = 1e-14, kMost = 10, kTenth = 0.1, kLess = 0.9, kBarely = 0.9999;
  double left = calc_residual(s, slips, s.forces, s.middle);
  double lambda = std::clamp(1e-3 * (left / fastest) * (left / fastest), kLeast, 1.0);
  int refused = 0;
  bool moved = true;
  for (int i = 0; i < kMostCone && left > kEnough * fastest && lambda <= kMost; ++i) {
    if (moved) update_derivative(slips, s);
    moved = false;
    if (set_trial(lambda, s.middle, s)) {
      const double next = calc_residual(s, slips, s.trial, s.residual);
      if (next < (refused > 3 ? kBarely : kLess) * left) {
        std::copy_n(s.trial.begin(), s.count, s.forces.begin());
        std::copy_n(s.residual.begin(), s.count, s.middle.begin());
        left = next;
        lambda = std::max(kLeast, kTenth * lambda);
        refused = 0;
        moved = true;
        continue;
      }
    }
    ++refused;
    lambda *= 10;
  }
  return left / fastest;
}

}  // namespace unlatch
