// Bounds of distances within a piece of motion against dense searches: a bound that skips must never skip a touch.
#include "hil/run/motion/shape_dips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/motion/motion_bend.h"
#include "hil/run/run.h"
#include "hil/scenario/scenario.h"
#include "tests/support/random.h"

namespace unlatch::test::shape_dips_test {
namespace {

constexpr int kDense = 200;          // instants of a piece
constexpr double kRounding = 1e-12;  // m, at sizes of a metre

Vec3 draw_vector(Random& random, double limit) {
  return {random.uniform(-limit, limit), random.uniform(-limit, limit), random.uniform(-limit, limit)};
}

// Both ends of a piece, of two bodies and the ground, with whatever accelerations.
struct Ends {
  std::vector<BodyState> start, end;
  std::vector<Spatial> at_start, at_end;
  double h = 0;

  [[nodiscard]] hil::MotionPiece get() const { return {0, h, start, end, at_start, at_end}; }
};

// The second body is some `apart` from the first. `wild`: how fast they move and turn.
Ends draw_ends(Random& random, double apart, double wild) {
  Ends out;
  out.h = random.uniform(1e-4, 2e-3);
  for (int body = 0; body < 2; ++body) {
    const Vec3 turn = draw_vector(random, 1), v = draw_vector(random, wild), w = draw_vector(random, 3 * wild);
    const Spatial a{draw_vector(random, 30 * wild), draw_vector(random, 100 * wild)},
        b{draw_vector(random, 30 * wild), draw_vector(random, 100 * wild)};
    const Quat q = normalized(Quat{1, turn.x, turn.y, turn.z});
    const BodyState start{body == 0 ? Vec3{0, 0, 0} : draw_vector(random, apart), q, v, w};
    // Some ends that no constant acceleration leads to.
    const Vec3 w_end = w + out.h * transpose_times(rotation_matrix(q), a.ang);
    const Vec3 half = (0.25 * out.h) * (w + w_end);
    const Quat by = normalized(Quat{1, half.x, half.y, half.z});
    const Quat turned{
        q.w * by.w - (q.x * by.x + q.y * by.y + q.z * by.z), q.w * by.x + q.x * by.w + (q.y * by.z - q.z * by.y),
        q.w * by.y + q.y * by.w + (q.z * by.x - q.x * by.z), q.w * by.z + q.z * by.w + (q.x * by.y - q.y * by.x)};
    const double sign = random.chance(0.2) ? -1 : 1;  // the same attitude
    out.start.push_back(start);
    out.end.push_back({start.p + out.h * (v + (0.5 * out.h) * a.lin),
                       {sign * turned.w, sign * turned.x, sign * turned.y, sign * turned.z},
                       v + out.h * a.lin,
                       w_end});
    out.at_start.push_back(a);
    out.at_end.push_back(random.chance(0.5) ? a : b);
  }
  for (std::vector<BodyState>* ends : {&out.start, &out.end}) ends->push_back(hil::get_rest());
  for (std::vector<Spatial>* ends : {&out.at_start, &out.at_end}) ends->push_back({{0, 0, 0}, {0, 0, 0}});
  return out;
}

TEST(MotionBend, PointsDepartFromTheirChordsByNoMore) {
  constexpr std::uint64_t kSeed = 31;
  Random random(kSeed);
  double nearest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double wild = std::pow(10.0, random.uniform(-3, 1.5));
    const Ends ends = draw_ends(random, 2, wild);
    const hil::MotionPiece piece = ends.get();
    const std::size_t from = i % 3 == 0 ? 2 : 0, seen = 1;
    const Vec3 point = draw_vector(random, 0.5), axis = draw_vector(random, 1), n = (1 / norm(axis)) * axis;
    const double bend = hil::calc_bend(piece, from, seen, norm(point));
    const auto calc = [&](double time) {
      const BodyState a = piece.calc_body(from, time), b = piece.calc_body(seen, time);
      return dot(n, transpose_times(rotation_matrix(a.q), (b.p - a.p) + rotation_matrix(b.q) * point));
    };
    const double begin = calc(0), end = calc(ends.h);
    for (int k = 1; k < kDense; ++k) {
      const double s = static_cast<double>(k) / kDense;
      const double off = std::fabs(calc(s * ends.h) - ((1 - s) * begin + s * end));
      ASSERT_LE(off, bend + kRounding) << "seed " << kSeed << ", " << i << " at " << s;
      nearest = std::max(nearest, off / bend);
    }
  }
  EXPECT_GT(nearest, 0.1);  // it is no bound of everything
}

// Two bodies of two shapes each: round ones, faces, rims, a wall.
std::string draw_two(Random& random) {
  const char* const shapes[] = {"cylinder: {from: [-0.3, 0, 0], to: [0.3, 0, 0], radius: 0.2}",
                                "box: {size: [0.5, 0.3, 0.4]}",
                                "box: {centre: [0.1, 0, 0.1], size: [0.2, 0.6, 0.1]}",
                                "cone: {from: [0, 0, -0.2], to: [0, 0, 0.3], radius: 0.3}",
                                "sphere: {centre: [0.2, 0, 0], radius: 0.2}",
                                "capsule: {from: [0, -0.3, 0], to: [0, 0.3, 0.1], radius: 0.1}",
                                "frustum: {from: [0, 0, -0.2], to: [0.1, 0, 0.3], radius: 0.3, end_radius: 0.1}",
                                "hull: {points: [[0, 0, 0], [0.4, 0, 0], [0, 0.4, 0], [0, 0, 0.4], [0.2, 0.2, 0.3]]}"};
  std::string text = "unlatch: 1\nname: two\nstep: {dt: 1 ms, until: 1}\nclearance: all\nbodies:\n";
  for (int b = 0; b < 2; ++b)
    text += "  b" + std::to_string(b) + ": {mass: 1, inertia: [1, 1, 1], position: [" + std::to_string(b) +
            ", 0, 0], shape: [{" + shapes[random.below(8)] + "}, {" +
            (b == 0 && random.chance(0.1) ? "hollow_cylinder: {from: [0, 0, -0.5], to: [0, 0, 0.5], radius: 0.5}"
                                          : shapes[random.below(8)]) +
            "}]}\n";
  return text;
}

TEST(ShapeDips, NoDistanceIsBelowWhatStaysAbove) {
  constexpr std::uint64_t kSeed = 32;
  Random random(kSeed);
  int above = 0, near = 0, overlapping = 0;
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(i));
    const hil::Scenario scenario = hil::load_scenario_text(draw_two(random), "two.yaml");
    const hil::ClearanceMonitor monitor(scenario.clearance, scenario.shapes);
    hil::ShapeDips dips(monitor, 0, 0, 1);
    Ends ends = draw_ends(random, 0.7, std::pow(10.0, random.uniform(-3, 1)));
    for (int piece_number = 0; piece_number < 3; ++piece_number) {  // planes of one piece serve the next
      const hil::MotionPiece piece = ends.get();
      const auto calc = [&](double time) {
        return monitor.calc(0, hil::to_placement(piece.calc_body(0, time)), hil::to_placement(piece.calc_body(1, time)))
            .least.distance;
      };
      double least = HUGE_VAL;
      for (int k = 0; k <= kDense; ++k) least = std::min(least, calc(ends.h * k / kDense));
      for (const double margin : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, -1e-9, -1e-7, -1e-5, -1e-3}) {
        const bool stays = dips.stays_above(monitor, piece, least - margin);
        if (margin < 0) {
          EXPECT_FALSE(stays) << margin;  // at some instant the distance is below
        }
        above += stays;
        near += stays && margin <= 1e-5;
        overlapping += stays && margin <= 1e-4 && least < 0;
      }
      // Goes on from the end.
      ends.start = ends.end;
      ends.at_start = ends.at_end;
      for (std::size_t b = 0; b < 2; ++b) {
        ends.end[b].p = ends.start[b].p + ends.h * ends.start[b].v;
        ends.end[b].q = ends.start[b].q;
      }
    }
  }
  EXPECT_GT(above, 500);
  EXPECT_GT(near, 30);
  EXPECT_GT(overlapping, 15);
}

TEST(ShapeDips, SkippedPairsOfShapesChangeNoBit) {
  constexpr std::uint64_t kSeed = 33;
  Random random(kSeed);
  int found = 0;
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(i));
    const hil::Scenario scenario = hil::load_scenario_text(draw_two(random), "two.yaml");
    const hil::ClearanceMonitor monitor(scenario.clearance, scenario.shapes);
    hil::ShapeDips some(monitor, 0, 0, 1), all(monitor, 0, 0, 1, hil::Skipping::kOff);
    const Ends ends = draw_ends(random, 0.7, std::pow(10.0, random.uniform(0, 2)));
    const hil::MotionPiece piece = ends.get();
    const auto calc = [&](double time) {
      return monitor.calc(0, hil::to_placement(piece.calc_body(0, time)), hil::to_placement(piece.calc_body(1, time)))
          .least.distance;
    };
    const hil::DipSearch search{
        .length = HUGE_VAL, .limit = std::min(calc(0), calc(ends.h)), .resolution = monitor.get_resolution(0)};
    (void)some.stays_above(monitor, piece, search.limit - 1e-3);
    const std::optional<hil::Dip> a = some.find(monitor, piece, search), b = all.find(monitor, piece, search);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ++found;
    EXPECT_EQ(a->time, b->time);
    EXPECT_EQ(a->value, b->value);
    EXPECT_LT(a->value, search.limit);
    EXPECT_NEAR(a->value, calc(a->time), kRounding);
  }
  EXPECT_GT(found, 10);
}

TEST(ShapeDips, DistancesWithinAPieceAndTheOneBeforeHaveTheBitsOfTheMonitor) {
  constexpr std::uint64_t kSeed = 34;
  Random random(kSeed);
  int present = 0, before = 0;
  for (int run = 0; run < 60; ++run) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(run));
    std::string text = draw_two(random);
    for (std::size_t at = text.find("shape: "); at != std::string::npos; at = text.find("shape: ", at)) {
      const Vec3 v = draw_vector(random, 3), w = draw_vector(random, 5);
      const auto print = [](const Vec3& a) {
        return "[" + std::to_string(a.x) + ", " + std::to_string(a.y) + ", " + std::to_string(a.z) + "], ";
      };
      const std::string motion = "velocity: " + print(v) + "rate: " + print(w);
      text.insert(at, motion);
      at += motion.size() + 1;
    }
    const hil::Scenario scenario = hil::load_scenario_text(text, "two.yaml");
    const auto simulation = hil::build_simulation(scenario);
    simulation->keep_motion();
    const hil::ClearanceMonitor monitor(scenario.clearance, scenario.shapes);
    hil::ShapeDips dips(monitor, 0, 0, 1);
    hil::MotionWindow window;
    for (int tick = 1; tick <= 100; ++tick) {
      ASSERT_EQ(simulation->step().status, StepStatus::kOk);
      const std::span<const MotionKnot> knots = simulation->get_motion();
      window.move_on(knots[0], knots[1]);
      const hil::MotionPiece& piece = window.get_present();
      if (random.chance(0.1)) continue;  // a piece that is not asked for
      (void)dips.stays_above(monitor, piece, random.uniform(0, 0.5));
      for (int look = 0; look < 4; ++look) {
        const double time = std::max(0.0, random.uniform(piece.from - 1e-3, piece.to));
        const std::optional<double> known = dips.calc_within(monitor, window, time);
        if (!known) continue;
        ++(time < piece.from ? before : present);
        EXPECT_EQ(
            *known,
            monitor.calc(0, hil::to_placement(window.calc_body(0, time)), hil::to_placement(window.calc_body(1, time)))
                .least.distance);
      }
    }
  }
  EXPECT_GT(present, 5000);
  EXPECT_GT(before, 3000);
}

}  // namespace
}  // namespace unlatch::test::shape_dips_test
