// Compliant contacts: forces of pairs of shapes that are closed. K. H. Hunt and F. R. E. Crossley, "Coefficient of
// restitution interpreted as damping in vibroimpact", 1975; regularised Coulomb friction. THEORY.md has the law.
//
// A pair that is open at the beginning of a sub-step has no force within it: the sub-step ends where it touches
// (kernel/step), so that stages see a smooth force. Cost: one distance per closed pair and stage.
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/elements/energy_sum.h"
#include "kernel/model/check.h"
#include "unlatch/contacts.h"
#include "unlatch/readings.h"

namespace unlatch {

inline geometry::Placement get_placement(const BodyFrame& body) { return {body.p, body.R}; }
// One shape of those of a body.
geometry::ShapeView get_shape(const PlanData& plan, const PlanShapes& of, std::int32_t part) noexcept;

// A pair of shapes at one instant; forces at the contact's switch scale.
struct PairForce {
  Vec3 point{0, 0, 0};              // midpoint of the witnesses, W, m
  Vec3 force{0, 0, 0};              // on the follower, at `point`, N
  double depth = 0, rate = 0;       // δ, m; dδ/dt, m/s
  double normal = 0, friction = 0;  // F_n and |F_t|, N
  Vec3 slip_velocity{0, 0, 0};      // v_t, W, m/s
  double slip = 0;                  // |v_t|, m/s
  double elastic = 0, stored = 0;   // k δⁿ, N; k δⁿ⁺¹/(n + 1), J
  double stiffness = 0;             // n k δⁿ⁻¹, N/m
  double calc_loss() const { return (normal - elastic) * rate + friction * slip; }  // W
};
PairForce calc_pair_force(const PlanContact& contact, const geometry::Distance& distance, const BodyFrame& base,
                          const BodyFrame& follower, double scale) noexcept;

// How the force of a closed pair changes, of the friction without what follows from the depth. N/m of depth; N s/m of
// its rate, of the slip along itself, and of slip across it.
struct PairSlopes {
  double stiffness = 0, damping = 0, along = 0, across = 0;
};
PairSlopes calc_slopes(const PlanContact& contact, const ClosedPair& pair, double scale) noexcept;

// A body and the acceleration of its origin.
struct MovingFrame {
  BodyFrame frame;
  Spatial acceleration;  // W axes
};
// Second derivative of the depth of a pair, m/s², from its rate now and that a moment later. `step`: of which a moment
// is a small part, s.
double calc_depth_acceleration(const PlanData& plan, const ContactPair& pair, const MovingFrame& base,
                               const MovingFrame& follower, double rate, double step) noexcept;

// Speed of the slip of a contact, m/s: of its closed pairs the mean weighted by F_n; where none pushes, as at the
// instant of a touch or a lift, the plain mean.
class SlipMean {
 public:
  void add(double normal, double slip) {
    const double weight = normal > 0 ? normal : 0;
    weight_ += weight;
    weighted_ += weight * slip;
    sum_ += slip;
    count_ += 1;
  }
  [[nodiscard]] double get() const { return weight_ > 0 ? weighted_ / weight_ : count_ > 0 ? sum_ / count_ : 0; }

 private:
  double weight_ = 0, weighted_ = 0, sum_ = 0, count_ = 0;
};

// Rates of a contact's totals, of which each closed pair adds its force, N, slip, m/s, and loss, W.
class ContactRates {
 public:
  void add(double normal, double slip, double loss) {
    force_ += normal;
    slip_.add(normal, slip);
    loss_ += loss;
  }
  void store(const PlanContact& contact, Evaluation& ev) const noexcept;

 private:
  double force_ = 0, loss_ = 0;
  SlipMean slip_;
};

// Adds to a rigid contact's impulse (N s) and loss (J) at one instant.
void add_impulse(const PlanContact& contact, double impulse, double loss, Evaluation& ev) noexcept;

// k δⁿ⁺¹/(n + 1) at scale 1, J.
double calc_stored(const PlanContact& contact, double depth) noexcept;

// Signed distance of two surfaces where a guard could cross `threshold` within a step; farther apart a lower bound,
// which is above `threshold`.
double calc_guarded_distance(const PlanData& plan, const Evaluation& ev, int a, int b, double threshold) noexcept;

// ev.pair_distances and ev.pair_rates of pairs that are open and on: distances and their rates, or lower bounds of
// those that cannot touch within a step and 0.
void update_open_pairs(const Instant& now, Evaluation& ev) noexcept;

// The distance of a pair as update_open_pairs() finds it, m; where hulls touch at edges, it differs from a rigid row's
// gap by what the search for it leaves.
double calc_open_distance(const PlanData& plan, std::size_t pair, const Evaluation& ev) noexcept;
// Margins of a pair that is closed, by ev.closed_pairs; not a number if its contact is off or rigid.
PairFeature calc_pair_feature(const PlanData& plan, std::size_t pair, bool off, const Evaluation& ev) noexcept;

// A contact at any instant of a step, of which `ev` is the evaluation.
ContactReading calc_contact(const Instant& now, const Evaluation& ev, int contact) noexcept;

// Distance of two surfaces.
double calc_shape_distance(const PlanData& plan, const Evaluation& ev, int a, int b) noexcept;

// d, s/m, of a contact whose blow with `speed` (m/s) parts with `restitution` (0 < e ≤ 1) times that speed; the same
// for all masses, stiffnesses and exponents. From dE = F dδ: v dv/(1 + d v) has the same integral from v to 0 and from
// 0 to −e v, so that x = d v solves x (1 + e) = ln((1 + x)/(1 − e x)).
double calc_contact_damping(double restitution, double speed);

struct ContactKind {
  static auto& of(auto& model) { return model.contacts; }
  static auto& of_plan(auto& plan) { return plan.contacts; }

  static void list_numbers(const Contact& c, const auto& add) {
    add(c.base, c.follower, c.stiffness, c.exponent, c.damping, c.restitution, c.speed, c.friction, c.slip_speed, c.on,
        c.except);
    if (c.rigid) add(c.rigid, c.settle);
  }
  static void shift(Contact& c, const auto& by) {
    by.shift_surface(c.base);
    by.shift_surface(c.follower);
  }
  static bool reads_speed(const Contact& c) { return c.rigid || c.damping != 0 || c.restitution || c.friction != 0; }
  static ElementTraits describe(const Model& model, const Contact& c);
  static void validate(const Contact& contact, const Check& check);
  static PlanContact compile(const Contact& contact, ElementCompiler& compiler);
  static ElementStart start(const Model&, const Contact&) { return {}; }

  static bool holds_ground(const PlanData& plan, const State&, const PlanContact& own) {
    return plan.shapes[at(own.base)].body == kGround || plan.shapes[at(own.follower)].body == kGround;
  }
  // Some pair of its shapes is closed.
  static bool acts(const Instant& now, const Evaluation&, const PlanContact& own, std::size_t) {
    for (std::int32_t i = 0; i < own.pairs; ++i)
      if (now.state.contacts[at(own.first_pair + i)].closed != 0) return true;
    return false;
  }
  // Adds the forces of closed pairs, and the rates of the contact's totals; ev.pair_distances and ev.closed_pairs of
  // those pairs. Nothing of a rigid contact: its forces follow from the accelerations (rigid_row.h).
  static void add_forces(const Instant& now, const PlanContact& own, double scale, Evaluation& ev);
  static ElementReading read(const auto&, const PlanContact&, std::size_t, double scale) { return {.scale = scale}; }
  // Energy that closed pairs store, and all that the contact has lost.
  static void add_energy(const StageMotion& motion, const PlanContact& own, std::size_t, EnergySum& sum);
};

}  // namespace unlatch
