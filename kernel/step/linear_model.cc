#include "unlatch/linear_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/joints/kinematics.h"
#include "kernel/model/from_eigen.h"
#include "kernel/solver/loops/loop_rows.h"
#include "kernel/step/state_copy.h"
#include "kernel/step/velocities.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LinearCoordinate::Kind;

// Width of the wider differences: m and rad of coordinates, m/s and rad/s of speeds below 1. Together with a second
// width of half of it, errors are of the fourth order; rounding adds some 1e-12 of the accelerations.
constexpr double kWidth = 1e-3;
// A coordinate is free if those before it leave it at least this part of its mobility.
constexpr double kLeastFreedom = 1e-9;
// A mobility below this part of the largest is rounding: rows hold the coordinate.
constexpr double kLeastMobility = 1e-13;
// Forces have a corner where the second difference over the width does not fall with the width, and is at least this
// part of the derivative.
constexpr double kLeastCorner = 1e-3;
// Rounding of an acceleration, beside the largest one.
constexpr double kRounding = 1e-10;

// The numbers of one state of which differences are taken.
struct Sample {
  VectorXd accelerations, outputs;
};

class Linearisation {
 public:
  Linearisation(const Plan& owner, const State& state, std::span<const double> commands, const LinearOutputs& outputs)
      : owner_(owner),
        plan_(get_data(owner)),
        state_(state),
        outputs_(outputs),
        velocities_(plan_),
        commands_(commands.begin(), commands.end()),
        memory_(new (std::align_val_t{kAlignment}) std::byte[owner.get_workspace_bytes()]),
        workspace_(owner, {memory_.get(), owner.get_workspace_bytes()}),
        velocity_(velocities_.read(state)) {}

  std::optional<LinearModel> calc() {
    if (!update(state_)) return std::nullopt;
    choose_coordinates();
    const Index f = std::ssize(coordinates_), outputs = count_outputs(), channels = std::ssize(commands_);
    LinearModel model;
    model.coordinates = coordinates_;
    const std::optional<Sample> middle = sample(state_);
    if (!middle) return std::nullopt;
    model.accelerations = middle->accelerations;
    for (auto* matrix : {&model.A, &model.A_error}) *matrix = MatrixXd::Zero(2 * f, 2 * f);
    for (auto* matrix : {&model.B, &model.B_error}) *matrix = MatrixXd::Zero(2 * f, channels);
    for (auto* matrix : {&model.C, &model.C_error}) *matrix = MatrixXd::Zero(outputs, 2 * f);
    for (auto* matrix : {&model.D, &model.D_error}) *matrix = MatrixXd::Zero(outputs, channels);
    model.A.topRightCorner(f, f).setIdentity();
    model.A.topLeftCorner(f, f) = calc_rates_by_coordinates();

    for (Index k = 0; k < 2 * f + channels; ++k) {
      const bool commanded = k >= 2 * f;
      const auto take = [&](double width) { return commanded ? command(k - 2 * f, width) : deviate(k, width); };
      const std::optional<Difference> difference = differentiate(take, calc_width(k, f), *middle);
      if (!difference) return std::nullopt;
      if (difference->corner) model.corners.push_back(static_cast<int>(k));
      const Index column = commanded ? k - 2 * f : k;
      (commanded ? model.B : model.A).col(column).tail(f) = difference->value.accelerations;
      (commanded ? model.B_error : model.A_error).col(column).tail(f) = difference->error.accelerations;
      (commanded ? model.D : model.C).col(column) = difference->value.outputs;
      (commanded ? model.D_error : model.C_error).col(column) = difference->error.outputs;
    }
    return model;
  }

 private:
  static constexpr std::size_t kAlignment = 64;
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete[](memory, std::align_val_t{kAlignment}); }
  };
  struct Difference {
    Sample value, error;
    bool corner;
  };

  Evaluation& ev() { return get_data(workspace_).kept.evaluation; }
  Index count_outputs() const { return std::ssize(outputs_.sensors) + std::ssize(outputs_.quantities); }

  // The evaluation of a state: frames, accelerations, sensors; and the factor of the solver.
  bool update(const State& state) { return update_outputs(owner_, {commands_}, state, workspace_) == StepStatus::kOk; }

  // The nearest velocity, weighted with the masses, at which the rows that hold stay closed.
  bool project_velocity(State& state) {
    get_data(workspace_).kept.valid = false;
    load_state(plan_, state, ev());
    update_kinematics(plan_, ev());
    return apply_impulse(plan_, Source::kNothing, state, ev()) == kNone;
  }

  // Accelerations that unit forces bring about, with the rows that hold: symmetric, of rank f; its columns span the
  // directions in which the system is free. At the evaluation of the latest update().
  MatrixXd calc_mobility() {
    MatrixXd mobility(velocities_.size(), velocities_.size());
    double* blocks = ev().blocks.data();
    const auto clear = [&] {
      for (const Place& place : plan_.places) write(blocks, place, &SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
      clear_modal_forces(plan_, ev());
    };
    const auto solve = [&](Index column) {
      get_kernels(plan_).solve(plan_, ev(), {.biased = false, .multipliers = false});
      mobility.col(column) = read_accelerations();
    };
    for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
      if (velocities_.first(b) == kNone) continue;
      const Mat3 R = read(blocks, ev().places[b], &BodyLane::R);
      for (int i = 0; i < 6; ++i) {
        clear();
        const Vec3 world{i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
        const Spatial wrench = i < 3 ? Spatial{world, {0, 0, 0}} : Spatial{{0, 0, 0}, column(R, i - 3)};
        write(blocks, ev().places[b], &SharedLane::force, wrench);
        solve(velocities_.first(b) + i);
      }
    }
    for (std::size_t i = 0; i < plan_.flexible.size(); ++i) {
      for (int k = 0; k < plan_.flexible[i].modes; ++k) {
        clear();
        get_work(plan_.flexible[i], ev()).force[at(k)] = 1;
        solve(velocities_.modal(i) + k);
      }
    }
    return 0.5 * (mobility + mobility.transpose());
  }

  // Of the latest solution: dv/dt in W, dw/dt in body axes, second derivatives of modal coordinates.
  VectorXd read_accelerations() {
    VectorXd a(velocities_.size());
    for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
      if (velocities_.first(b) == kNone) continue;
      const Spatial own = ev().get_acceleration(static_cast<int>(b));
      const Mat3 R = read(ev().blocks.data(), ev().places[b], &BodyLane::R);
      a.segment<3>(velocities_.first(b)) = to_eigen(own.lin);
      a.segment<3>(velocities_.first(b) + 3) = to_eigen(transpose_times(R, own.ang));
    }
    for (std::size_t i = 0; i < plan_.flexible.size(); ++i) {
      const ModalWork work = get_work(plan_.flexible[i], ev());
      for (int k = 0; k < plan_.flexible[i].modes; ++k) a[velocities_.modal(i) + k] = work.acceleration[at(k)];
    }
    return a;
  }

  // Adds the coefficients of a wrench's power on a body to a row of coefficients of the velocities.
  void add_coefficients(int body, const Spatial& wrench, Eigen::Ref<Eigen::RowVectorXd> row) {
    if (body == kGround) return;
    const Index first = velocities_.first(at(body));
    if (first != kNone) {
      const Mat3 R = read(ev().blocks.data(), ev().places[at(body)], &BodyLane::R);
      row.segment<3>(first) += to_eigen(wrench.lin).transpose();
      row.segment<3>(first + 3) += to_eigen(transpose_times(R, wrench.ang)).transpose();
      return;
    }
    const auto marker = std::ranges::find(plan_.markers, body, &PlanMarker::body);
    const PlanFlexible& own = plan_.flexible[at(marker->flexible)];
    const MarkerWork work = get_marker(own, static_cast<int>(marker - plan_.markers.begin()) - own.first_marker, ev());
    add_coefficients(own.body, shift_wrench(wrench, *work.arm), row);
    for (int k = 0; k < own.modes; ++k)
      row[velocities_.modal(at(marker->flexible)) + k] += dot(wrench, work.columns[at(k)]);
  }

  // Coefficients of a coordinate's speed in the velocities, at the evaluation of the latest update().
  Eigen::RowVectorXd calc_coefficients(const LinearCoordinate& own) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(velocities_.size());
    switch (own.kind) {
      case Kind::kPosition:
        row[velocities_.first(at(own.subject)) + own.axis] = 1;
        break;
      case Kind::kAttitude:
        row[velocities_.first(at(own.subject)) + 3 + own.axis] = 1;
        break;
      case Kind::kModal:
        row[velocities_.modal(find_flexible(own.subject)) + own.axis] = 1;
        break;
      case Kind::kJoint: {
        const PlanJoint& joint = plan_.joints[at(own.subject)];
        const JointFrame frame = get_joint_frame(plan_, state_, ev(), own.subject);
        add_coefficients(joint.follower, calc_row_wrench(frame, own.axis, true), row);
        add_coefficients(joint.base, calc_row_wrench(frame, own.axis, false), row);
        break;
      }
    }
    return row;
  }

  std::size_t find_flexible(int body) const {
    return static_cast<std::size_t>(std::ranges::find(plan_.flexible, body, &PlanFlexible::body) -
                                    plan_.flexible.begin());
  }

  // All coordinates that may be free, in the order of preference.
  std::vector<LinearCoordinate> list_candidates() const {
    std::vector<LinearCoordinate> all;
    for (std::size_t j = 0; j < plan_.joints.size(); ++j) {
      const RowSet rows = get_active_rows(plan_, state_, static_cast<int>(j));
      if (rows == 0) continue;
      for (int r = 0; r < kRows; ++r)
        if (!has_row(rows, r)) all.push_back({Kind::kJoint, static_cast<int>(j), r});
    }
    for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
      if (velocities_.first(b) == kNone) continue;
      for (const Kind kind : {Kind::kPosition, Kind::kAttitude})
        for (int i = 0; i < 3; ++i) all.push_back({kind, static_cast<int>(b), i});
    }
    for (const PlanFlexible& own : plan_.flexible)
      for (int k = 0; k < own.modes; ++k) all.push_back({Kind::kModal, own.body, k});
    return all;
  }

  // A coordinate is taken if those before leave it some mobility: a Cholesky factor of the mobilities along the
  // candidates, in their order. Its inverse turns speeds of coordinates into velocities, which keep the rows closed.
  void choose_coordinates() {
    const std::vector<LinearCoordinate> candidates = list_candidates();
    std::vector<Eigen::RowVectorXd> rows;
    for (const LinearCoordinate& own : candidates) rows.push_back(calc_coefficients(own));
    const MatrixXd mobility = calc_mobility();
    const double scale = mobility.diagonal().maxCoeff();
    std::vector<VectorXd> factor;  // of each chosen one: its row of the factor
    std::vector<VectorXd> pushed;  // and the mobility times its coefficients
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const VectorXd response = mobility * rows[i].transpose();
      const double whole = rows[i].dot(response);
      VectorXd own(std::ssize(factor) + 1);
      double left = whole;
      for (Index k = 0; k < std::ssize(factor); ++k) {
        double sum = pushed[static_cast<std::size_t>(k)].dot(rows[i]);
        for (Index l = 0; l < k; ++l) sum -= own[l] * factor[static_cast<std::size_t>(k)][l];
        own[k] = sum / factor[static_cast<std::size_t>(k)][k];
        left -= own[k] * own[k];
      }
      if (!(left > kLeastFreedom * whole) || !(whole > kLeastMobility * scale)) continue;
      own[std::ssize(factor)] = std::sqrt(left);
      factor.push_back(std::move(own));
      pushed.push_back(response);
      coordinates_.push_back(candidates[i]);
    }
    const Index f = std::ssize(coordinates_);
    MatrixXd gram(f, f);
    directions_.resize(velocities_.size(), f);
    for (Index k = 0; k < f; ++k) {
      directions_.col(k) = pushed[static_cast<std::size_t>(k)];
      for (Index l = 0; l <= k; ++l)
        gram(k, l) = factor[static_cast<std::size_t>(k)].head(l + 1).dot(factor[static_cast<std::size_t>(l)]);
    }
    const MatrixXd inverse = gram.selfadjointView<Eigen::Lower>().ldlt().solve(MatrixXd::Identity(f, f));
    directions_ = (directions_ * inverse).eval();
  }

  // Speeds of the coordinates at a state with this velocity, which need not keep the rows closed.
  std::optional<VectorXd> calc_speeds(State& state, const VectorXd& velocity) {
    velocities_.write(velocity, state);
    if (!update(state)) return std::nullopt;
    VectorXd speeds(std::ssize(coordinates_));
    for (Index k = 0; k < speeds.size(); ++k)
      speeds[k] = calc_coefficients(coordinates_[static_cast<std::size_t>(k)]).dot(velocity);
    return speeds;
  }

  // Accelerations of the coordinates and outputs at a state.
  std::optional<Sample> sample(const State& state) {
    if (!update(state)) return std::nullopt;
    const VectorXd a = read_accelerations();
    Sample out{VectorXd(std::ssize(coordinates_)), VectorXd(count_outputs())};
    for (Index k = 0; k < out.accelerations.size(); ++k) {
      const LinearCoordinate& own = coordinates_[static_cast<std::size_t>(k)];
      out.accelerations[k] =
          own.kind == Kind::kJoint ? calc_joint_acceleration(state, own) : calc_coefficients(own).dot(a);
    }
    Index i = 0;
    for (const int sensor : outputs_.sensors) out.outputs[i++] = workspace_.sensors[at(sensor)];
    for (const int quantity : outputs_.quantities) out.outputs[i++] = workspace_.quantities[at(quantity)];
    return out;
  }

  // Second derivative of a displacement, or rate of an angular speed about an axis.
  double calc_joint_acceleration(const State& state, const LinearCoordinate& own) {
    const PlanJoint& joint = plan_.joints[at(own.subject)];
    const BodyFrame base = get_body_frame(ev(), joint.base), follower = get_body_frame(ev(), joint.follower);
    const JointFrame frame = get_joint_frame(plan_, state, ev(), own.subject);
    const Spatial zero{{0, 0, 0}, {0, 0, 0}};
    const Spatial a_b = joint.base == kGround ? zero : ev().get_acceleration(joint.base);
    const Spatial a_f = ev().get_acceleration(joint.follower);
    const Spatial target = calc_acceleration_target(base, follower, frame);
    if (own.axis < kRotX) {
      const Vec3 relative = (a_f.lin + cross(a_f.ang, frame.r_follower)) - (a_b.lin + cross(a_b.ang, frame.r_base));
      return dot(column(frame.n, own.axis), relative - target.lin);
    }
    const Vec3 m = column(frame.m, own.axis - kRotX), relative = a_f.ang - a_b.ang;
    // y of a universal joint's cross is the follower's
    if (own.axis == kRotY && is_crossed(joint, get_active_rows(plan_, state, own.subject)))
      return dot(m, relative) + dot(cross(follower.w, m), frame.w_rel);
    return dot(m, relative - target.ang);
  }

  // dq/dt by q: nothing but the turning of axes. With N δx what the motion itself does to a deviation, dq/dt =
  // u − δ(C) v + (dC/dt Z + C N Z) q; displacements and angles about one axis alone are exact, and have none of it.
  MatrixXd calc_rates_by_coordinates() {
    const Index f = std::ssize(coordinates_);
    MatrixXd out = MatrixXd::Zero(f, f);
    std::vector<Index> turning;
    for (Index k = 0; k < f; ++k)
      if (!is_exact(coordinates_[static_cast<std::size_t>(k)])) turning.push_back(k);
    if (turning.empty() || velocity_.isZero(0)) return out;
    const auto along = [&](const VectorXd& direction, double time, const VectorXd& velocity) {
      StateCopy moved(owner_, state_);
      velocities_.move(direction, time, moved.state);
      return calc_speeds(moved.state, velocity).value_or(VectorXd::Zero(f));
    };
    const auto differentiate_speeds = [&](const VectorXd& direction, const VectorXd& velocity) -> VectorXd {
      const double most = direction.cwiseAbs().maxCoeff(), width = kWidth / (most > 0 ? most : 1);
      const auto central = [&](double h) -> VectorXd {
        return (along(direction, h, velocity) - along(direction, -h, velocity)) / (2 * h);
      };
      return (4 * central(0.5 * width) - central(width)) / 3;
    };
    for (Index k = 0; k < f; ++k) {
      const VectorXd direction = directions_.col(k);
      VectorXd carried = VectorXd::Zero(velocities_.size());  // N Z
      for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
        if (velocities_.first(b) == kNone) continue;
        const Eigen::Vector3d w = velocity_.segment<3>(velocities_.first(b) + 3);
        carried.segment<3>(velocities_.first(b) + 3) =
            -w.cross(Eigen::Vector3d(direction.segment<3>(velocities_.first(b) + 3)));
      }
      const VectorXd sum = differentiate_speeds(velocity_, direction) + along(direction, 0, carried) -
                           differentiate_speeds(direction, velocity_);
      for (const Index row : turning) out(row, k) = sum[row];
    }
    return out;
  }
  bool is_exact(const LinearCoordinate& own) const {
    if (own.kind == Kind::kAttitude) return false;
    if (own.kind != Kind::kJoint || own.axis < kRotX) return true;
    const RowSet rows = get_active_rows(plan_, state_, own.subject);
    return std::popcount(static_cast<unsigned>(rows & kRotationRows)) >= 2;
  }

  double calc_width(Index k, Index f) const {
    if (k < f) return kWidth;
    if (k < 2 * f) return kWidth * std::max(1.0, velocity_.cwiseAbs().maxCoeff());
    return kWidth * std::max(1.0, std::abs(commands_[static_cast<std::size_t>(k - 2 * f)]));
  }

  // The state with coordinate or speed number k changed by `width`; the others, and the rows that hold, stay.
  std::optional<Sample> deviate(Index k, double width) {
    const Index f = std::ssize(coordinates_);
    StateCopy other(owner_, state_);
    if (k >= f) {
      velocities_.write(velocity_ + width * directions_.col(k - f), other.state);
      return sample(other.state);
    }
    velocities_.move(directions_.col(k), width, other.state);
    if (velocity_.isZero(0)) return sample(other.state);
    for (int pass = 0; pass < 2; ++pass) {
      if (!project_velocity(other.state)) return std::nullopt;
      const VectorXd projected = velocities_.read(other.state);
      const std::optional<VectorXd> speeds = calc_speeds(other.state, projected);
      if (!speeds) return std::nullopt;
      velocities_.write(projected + directions_ * (calc_own_speeds() - *speeds), other.state);
    }
    return sample(other.state);
  }
  const VectorXd& calc_own_speeds() {
    if (own_speeds_.size() == 0) {
      StateCopy same(owner_, state_);
      own_speeds_ = calc_speeds(same.state, velocity_).value_or(VectorXd::Zero(std::ssize(coordinates_)));
    }
    return own_speeds_;
  }
  std::optional<Sample> command(Index channel, double width) {
    double& value = commands_[static_cast<std::size_t>(channel)];
    const double kept = std::exchange(value, value + width);
    const std::optional<Sample> out = sample(state_);
    value = kept;
    return out;
  }

  template <class Take>
  std::optional<Difference> differentiate(const Take& take, double width, const Sample& middle) {
    const std::optional<Sample> a = take(width), b = take(-width), c = take(0.5 * width), d = take(-0.5 * width);
    if (!a || !b || !c || !d) return std::nullopt;
    Difference out{};
    const auto extrapolate = [&](VectorXd Sample::*part) {
      const VectorXd wide = (*a.*part - *b.*part) / (2 * width), narrow = (*c.*part - *d.*part) / width;
      out.value.*part = (4 * narrow - wide) / 3;
      out.error.*part = (narrow - wide).cwiseAbs();
    };
    extrapolate(&Sample::accelerations);
    extrapolate(&Sample::outputs);
    const VectorXd wide = (a->accelerations + b->accelerations - 2 * middle.accelerations) / width;
    const VectorXd narrow = (c->accelerations + d->accelerations - 2 * middle.accelerations) / (0.5 * width);
    if (middle.accelerations.size() == 0) return out;
    const double size = out.value.accelerations.cwiseAbs().maxCoeff();
    const double rounding = kRounding * (1 + middle.accelerations.cwiseAbs().maxCoeff()) / width;
    const double second = narrow.cwiseAbs().maxCoeff();
    out.corner = second > kLeastCorner * size + rounding && second > 0.75 * wide.cwiseAbs().maxCoeff();
    return out;
  }

  const Plan& owner_;
  const PlanData& plan_;
  const State& state_;
  const LinearOutputs& outputs_;
  const Velocities velocities_;
  std::vector<double> commands_;
  std::unique_ptr<std::byte[], Free> memory_;
  Workspace workspace_;
  const VectorXd velocity_;
  std::vector<LinearCoordinate> coordinates_;
  MatrixXd directions_;  // velocities by speeds of the coordinates
  VectorXd own_speeds_;
};

}  // namespace

std::optional<LinearModel> calc_linear_model(const Plan& plan, const State& state, std::span<const double> commands,
                                             const LinearOutputs& outputs) {
  return Linearisation(plan, state, commands, outputs).calc();
}

}  // namespace unlatch
