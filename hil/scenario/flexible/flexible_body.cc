#include "hil/scenario/flexible/flexible_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "hil/scenario/text/count.h"
#include "unlatch/inertia.h"

namespace unlatch::hil {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kRigidShare = 1e-4;    // remaining part of the modal mass of a mode without its rigid motion
constexpr double kIndependent = 1e-10;  // least eigenvalue of the Gram matrix of unit shapes
constexpr double kFlat = 1e-12;         // least moment of inertia, relative to the largest

struct MassProperties {
  double mass = 0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();
};

MassProperties calc_mass_properties(const std::vector<ModalPoint>& points) {
  MassProperties total;
  for (const ModalPoint& point : points) {
    total.mass += point.mass;
    total.centre += point.mass * point.position;
  }
  if (!(total.mass > 0)) throw std::invalid_argument("the points have no mass");
  total.centre /= total.mass;
  for (const ModalPoint& point : points) {
    const Vector3d r = point.position - total.centre;
    total.inertia += point.mass * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
  }
  const Vector3d principal = calc_principal_moments(total.inertia);
  if (!(principal[0] > kFlat * principal[2]))
    throw std::invalid_argument("the points with mass lie on one line: a rigid rotation about it has no inertia");
  return total;
}

// Moves the origin of points and markers to the centre of mass.
Modes centre(const Modes& modes, const Vector3d& origin) {
  Modes out = modes;
  for (ModalPoint& point : out.points) point.position -= origin;
  for (ModalMarker& marker : out.markers) marker.position -= origin;
  return out;
}

// Momenta of modes: ∫Φ dm above ∫ r × Φ dm, a column per mode.
Matrix6Xd calc_momenta(const Modes& modes) {
  Matrix6Xd momenta = Matrix6Xd::Zero(6, modes.get_count());
  for (const ModalPoint& point : modes.points)
    for (Index k = 0; k < modes.get_count(); ++k) {
      const Vector3d impulse = point.mass * point.shape.col(k);
      momenta.col(k).head<3>() += impulse;
      momenta.col(k).tail<3>() += point.position.cross(impulse);
    }
  return momenta;
}

MatrixXd calc_gram(const Modes& modes) {
  MatrixXd gram = MatrixXd::Zero(modes.get_count(), modes.get_count());
  for (const ModalPoint& point : modes.points)
    for (Index k = 0; k < modes.get_count(); ++k)
      for (Index l = 0; l <= k; ++l) gram(k, l) += point.mass * point.shape.col(k).dot(point.shape.col(l));
  return gram.selfadjointView<Eigen::Lower>();
}

// Combines shapes: column k of the result is Σ_j shape_j · a(j, k), summed in the order of j.
Matrix3Xd combine(const Matrix3Xd& shape, const MatrixXd& a) {
  Matrix3Xd out = Matrix3Xd::Zero(3, a.cols());
  for (Index k = 0; k < a.cols(); ++k)
    for (Index j = 0; j < a.rows(); ++j) out.col(k) += a(j, k) * shape.col(j);
  return out;
}

void recombine(const MatrixXd& a, Modes& modes) {
  for (ModalPoint& point : modes.points) point.shape = combine(point.shape, a);
  for (ModalMarker& marker : modes.markers) {
    marker.shape = combine(marker.shape, a);
    marker.rotation = combine(marker.rotation, a);
  }
}

// Removes from each mode the rigid motion that carries its momenta.
void remove_rigid_motion(const MassProperties& total, Modes& modes) {
  const Matrix6Xd momenta = calc_momenta(modes);
  const Matrix3Xd shift = momenta.topRows<3>() / total.mass;
  const Matrix3Xd turn = total.inertia.inverse() * momenta.bottomRows<3>();
  for (Index k = 0; k < modes.get_count(); ++k) {
    const Vector3d t = shift.col(k), rho = turn.col(k);
    for (ModalPoint& point : modes.points) point.shape.col(k) -= t + rho.cross(point.position);
    for (ModalMarker& marker : modes.markers) {
      marker.shape.col(k) -= t + rho.cross(marker.position);
      marker.rotation.col(k) -= rho;
    }
  }
}

double calc_off_unit(const MatrixXd& gram) {
  return (gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff();
}

// Momenta of modes of modal mass 1, relative to those of a mode of pure rigid motion.
double calc_momentum_share(const MassProperties& total, const Matrix6Xd& momenta) {
  double worst = 0;
  for (Index k = 0; k < momenta.cols(); ++k)
    for (Index i = 0; i < 6; ++i) {
      const double inertia = i < 3 ? total.mass : total.inertia(i - 3, i - 3);
      worst = std::max(worst, std::abs(momenta(i, k)) / std::sqrt(inertia));
    }
  return worst;
}

// Finds the elastic modes of the file, by index from 0. The report lists the others.
std::vector<Index> find_elastic(const Modes& found, const Modes& projected, FlexibleReport& report) {
  const VectorXd before = calc_gram(found).diagonal(), after = calc_gram(projected).diagonal();
  std::vector<Index> elastic;
  for (Index k = 0; k < found.get_count(); ++k) {
    const std::string mode = "mode " + std::to_string(k + 1);
    if (!(before[k] > 0)) throw std::invalid_argument(mode + " moves no mass");
    if (!(after[k] > kRigidShare * before[k])) {
      report.rigid.push_back(static_cast<int>(k) + 1);
    } else if (found.frequencies_hz[k] > 0) {
      elastic.push_back(k);
    } else {
      throw std::invalid_argument(mode + " has no frequency, and is no rigid motion");
    }
  }
  if (elastic.empty()) throw std::invalid_argument("all modes are rigid motions");
  return elastic;
}

// Columns of the identity matrix that select these modes.
MatrixXd build_picker(Index modes, const std::vector<Index>& picked) {
  MatrixXd a = MatrixXd::Zero(modes, static_cast<Index>(picked.size()));
  for (std::size_t i = 0; i < picked.size(); ++i) a(picked[i], static_cast<Index>(i)) = 1;
  return a;
}

void pick(const std::vector<Index>& picked, Modes& modes) {
  recombine(build_picker(modes.get_count(), picked), modes);
  VectorXd frequencies_hz(static_cast<Index>(picked.size()));
  for (std::size_t i = 0; i < picked.size(); ++i)
    frequencies_hz[static_cast<Index>(i)] = modes.frequencies_hz[picked[i]];
  modes.frequencies_hz = frequencies_hz;
}

// Solves the eigenproblem again. K = diag(ω²) for shapes that had unit modal mass in the file, M is their present Gram
// matrix: (K^-½ M K^-½) z = z/ω², and a = ω K^-½ z has aᵀ M a = 1, aᵀ K a = ω². The modes become those combinations;
// returns them, for the overlaps.
MatrixXd solve_again(Modes& modes) {
  const VectorXd inverse = (kTwoPi * modes.frequencies_hz).cwiseInverse();
  const MatrixXd gram = calc_gram(modes);
  MatrixXd problem(gram.rows(), gram.cols());
  for (Index i = 0; i < gram.rows(); ++i)
    for (Index j = 0; j < gram.cols(); ++j) problem(i, j) = inverse[i] * gram(i, j) * inverse[j];
  const Eigen::SelfAdjointEigenSolver<MatrixXd> independence(gram, Eigen::EigenvaluesOnly);
  if (!(independence.eigenvalues()[0] > kIndependent))
    throw std::invalid_argument("the modes are not independent: some is a combination of others");
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(problem);
  const Index count = gram.rows();
  MatrixXd a(count, count);
  for (Index k = 0; k < count; ++k) {
    const Index from = count - 1 - k;  // largest 1/ω² first
    const double omega = 1 / std::sqrt(eigen.eigenvalues()[from]);
    a.col(k) = omega * inverse.cwiseProduct(eigen.eigenvectors().col(from));
    Index largest = 0;
    a.col(k).cwiseAbs().maxCoeff(&largest);
    if (a(largest, k) < 0) a.col(k) *= -1;  // sign of the dominant original mode
    modes.frequencies_hz[k] = omega / kTwoPi;
  }
  recombine(a, modes);
  return a;
}

void scale_to_unit_mass(Modes& modes) {
  const VectorXd scale = calc_gram(modes).diagonal().cwiseSqrt().cwiseInverse();
  recombine(scale.asDiagonal().toDenseMatrix(), modes);
}

// Adds the effective masses of a mode of modal mass 1: (∫Φ dm)² kg move with it, likewise the moments; relative to the
// whole.
void add_effective_masses(const MassProperties& total, const Matrix6Xd& momenta, Index k, ModeFinding& finding) {
  finding.effective_mass = momenta.col(k).head<3>().cwiseAbs2() / total.mass;
  finding.effective_inertia = momenta.col(k).tail<3>().cwiseAbs2().cwiseQuotient(total.inertia.diagonal());
}

void add_compliances(const Modes& modes, FlexibleReport& report) {
  for (const ModalMarker& marker : modes.markers) {
    VectorXd linear(modes.get_count()), angular(modes.get_count());
    for (Index k = 0; k < modes.get_count(); ++k) {
      const double omega = kTwoPi * modes.frequencies_hz[k];
      linear[k] = marker.shape.col(k).squaredNorm() / (omega * omega);
      angular[k] = marker.rotation.col(k).squaredNorm() / (omega * omega);
    }
    const double sum = linear.sum(), angular_sum = angular.sum();
    for (Index k = 0; k < modes.get_count(); ++k) {
      ModeFinding& finding = report.modes[static_cast<std::size_t>(k)];
      finding.compliance.push_back(sum > 0 ? linear[k] / sum : 0);
      finding.angular_compliance.push_back(angular_sum > 0 ? angular[k] / angular_sum : 0);
    }
  }
}

}  // namespace

Modes condition_modes(const Modes& found, FlexibleReport& report) {
  report = {};
  const MassProperties total = calc_mass_properties(found.points);
  Modes modes = centre(found, total.centre), projected = modes;
  remove_rigid_motion(total, projected);
  const std::vector<Index> elastic = find_elastic(modes, projected, report);

  // Elastic modes found, each scaled to modal mass 1.
  pick(elastic, modes);
  scale_to_unit_mass(modes);
  const Matrix6Xd momenta = calc_momenta(modes);
  report.found_gram = calc_off_unit(calc_gram(modes));
  report.found_momentum = calc_momentum_share(total, momenta);
  const VectorXd file_hz = modes.frequencies_hz;

  // The second pass removes the round-off of the first.
  remove_rigid_motion(total, modes);
  remove_rigid_motion(total, modes);
  const MatrixXd overlap = calc_gram(modes) * solve_again(modes);
  report.gram = calc_off_unit(calc_gram(modes));
  report.momentum = calc_momentum_share(total, calc_momenta(modes));

  for (Index k = 0; k < modes.get_count(); ++k) {
    ModeFinding finding;
    finding.number = static_cast<int>(elastic[static_cast<std::size_t>(k)]) + 1;
    finding.file_hz = file_hz[k];
    finding.hz = modes.frequencies_hz[k];
    finding.overlap = std::abs(overlap(k, k));
    add_effective_masses(total, momenta, k, finding);
    report.modes.push_back(finding);
  }
  add_compliances(modes, report);
  return modes;
}

FlexibleStructure calc_invariants(const Modes& modes, const std::vector<double>& damping) {
  const MassProperties total = calc_mass_properties(modes.points);
  const Index count = modes.get_count();
  FlexibleStructure out;
  out.mass = total.mass;
  out.centre = total.centre;
  out.inertia = total.inertia;
  FlexibleBody& body = out.flexible;
  body.frequencies = kTwoPi * modes.frequencies_hz;
  body.damping.resize(count);
  for (Index k = 0; k < count; ++k) body.damping[k] = damping[damping.size() == 1 ? 0 : static_cast<std::size_t>(k)];
  body.momentum = calc_momenta(modes).topRows<3>();
  body.first.assign(static_cast<std::size_t>(count), Matrix3d::Zero());
  body.second.assign(static_cast<std::size_t>(count * count), Matrix3d::Zero());
  for (const ModalPoint& point : modes.points)
    for (Index k = 0; k < count; ++k) {
      const Vector3d impulse = point.mass * point.shape.col(k);
      body.first[static_cast<std::size_t>(k)] += point.position * impulse.transpose();
      for (Index l = 0; l < count; ++l)
        body.second[static_cast<std::size_t>(k * count + l)] += impulse * point.shape.col(l).transpose();
    }
  for (const ModalMarker& marker : modes.markers)
    out.markers.push_back({marker.name, {kNone, marker.position, marker.shape, marker.rotation}});
  return out;
}

void set_damping(const std::vector<double>& damping, FlexibleStructure& structure) {
  Eigen::VectorXd& ratios = structure.flexible.damping;
  const auto modes = static_cast<std::size_t>(ratios.size());
  if (damping.size() != 1 && damping.size() != modes)
    throw std::invalid_argument(count(damping.size(), "damping ratio") + " for " + count(modes, "mode") +
                                ": give one, or one for each");
  for (const double ratio : damping)
    if (!(ratio >= 0 && ratio < 1)) throw std::invalid_argument("a damping ratio is at least 0 and less than 1");
  for (std::size_t k = 0; k < modes; ++k) ratios[static_cast<Index>(k)] = damping[damping.size() == 1 ? 0 : k];
}

FlexibleStructure build_flexible_body(const Modes& found, const ModeSelection& selection, FlexibleReport& report) {
  const Vector3d origin = calc_mass_properties(found.points).centre;
  Modes modes = condition_modes(found, report);
  std::vector<Index> picked;
  std::vector<int> numbers = selection.numbers;
  if (numbers.empty())
    for (const ModeFinding& finding : report.modes) numbers.push_back(finding.number);
  for (const int number : numbers) {
    const auto finding = std::find_if(report.modes.begin(), report.modes.end(),
                                      [&](const ModeFinding& other) { return other.number == number; });
    if (finding == report.modes.end())
      throw std::invalid_argument("the file has no elastic mode " + std::to_string(number));
    if (finding->selected) throw std::invalid_argument("mode " + std::to_string(number) + " is selected twice");
    finding->selected = true;
    picked.push_back(finding - report.modes.begin());
  }
  pick(picked, modes);
  FlexibleStructure structure = calc_invariants(modes, {0});
  set_damping(selection.damping, structure);
  structure.centre += origin;
  return structure;
}

}  // namespace unlatch::hil
