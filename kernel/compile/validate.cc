// Mistakes of a model: all at once, each with its place and the remedy.
#include "kernel/model/validate.h"

#include <algorithm>

#include "kernel/elements/kinds/kinds.h"
#include "kernel/environment/environment_model.h"
#include "kernel/laws/law_model.h"
#include "unlatch/inertia.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

constexpr std::size_t kMostBodies = 2'000'000;  // some 700 numbers each at most, in places of 32 bits

constexpr double kRelative = 1e-9;  // inertias: rounding of what was typed or computed elsewhere

struct Named {
  std::string where, name;
};

// Checks that names are given and unique within their kind.
void check_names(const std::vector<Named>& list, ModelErrors& errors) {
  std::vector<std::string> seen;
  for (const Named& item : list) {
    if (item.name.empty()) errors.push_back({item.where, "it has no name", "give it one", "name"});
    seen.push_back(item.name);
  }
  std::sort(seen.begin(), seen.end());
  for (std::size_t i = 1; i < seen.size(); ++i) {
    if (seen[i].empty() || seen[i] != seen[i - 1] || (i > 1 && seen[i] == seen[i - 2])) continue;
    const auto at = std::find_if(list.begin(), list.end(), [&](const Named& item) { return item.name == seen[i]; });
    errors.push_back({at->where, "more than one has this name", "give each its own", "name"});
  }
}

void check_all_names(const Model& model, ModelErrors& errors) {
  const auto check = [&](const char* kind, const auto& items, const auto& get_name) {
    std::vector<Named> list;
    list.reserve(items.size());
    for (const auto& item : items) list.push_back({quoted(kind, get_name(item)), get_name(item)});
    check_names(list, errors);
  };
  const auto name_of = [](const auto& item) { return item.name; };
  const auto itself = [](const std::string& name) { return name; };
  std::vector<std::string> elements;
  elements.reserve(static_cast<std::size_t>(model.element_count()));
  for (int i = 0; i < model.element_count(); ++i) elements.push_back(model.element_name(i));
  check("body", model.bodies, name_of);
  check("joint", model.joints, name_of);
  check("element", elements, itself);
  check("channel", model.channels, name_of);
  check("signal", model.signals, itself);
  check("quantity", model.quantities, name_of);
  check("sensor", model.sensors, name_of);
  check("surface", model.surfaces, name_of);
  check("table", model.tables, name_of);
  check("law", model.laws, name_of);
}

// --- Bodies ---------------------------------------------------------------------------------------------------------

// Range of masses and moments of inertia: the solver multiplies four of them, which must not leave that of doubles.
constexpr double kSmallest = 1e-60, kLargest = 1e60;
constexpr const char* kSizes = "greater than 0: from 1e-60 to 1e60";
bool has_good_size(double number) { return number >= kSmallest && number <= kLargest; }

// Tolerance of the triangle inequality: CAD programs print I_z = I_x + I_y of a plate to three or four digits.
constexpr double kPlate = 1e-3;

void check_inertia(const Check& check, const Eigen::Matrix3d& J) {
  const auto report = [&](const std::string& what, const std::string& mend) { check.report(what, mend, "inertia"); };
  if (!J.allFinite()) return report("its inertia is not finite", "give finite moments of inertia");
  const double scale = J.cwiseAbs().maxCoeff();
  if ((J - J.transpose()).cwiseAbs().maxCoeff() > kRelative * scale)
    return report("its inertia is not symmetric", "entry (i, j) equals entry (j, i)");
  const Eigen::Vector3d moments = calc_principal_moments(J);
  if (!(moments[0] > 0))
    return report("its inertia is not positive definite: principal moments " + show(moments),
                  "all principal moments are greater than 0");
  if (!has_good_size(moments[0]) || !has_good_size(moments[2]))
    return report("its principal moments are " + show(moments) + " kg m²", kSizes);
  if (moments[0] + moments[1] < moments[2] * (1 - kPlate))
    report("its inertia breaks the triangle inequality: principal moments " + show(moments),
           "no body's largest principal moment exceeds the sum of the other two");
}

void check_law(const Check& check, const MassLaw& law) {
  const auto report = [&](const std::string& what, const std::string& mend) { check.report(what, mend, "law"); };
  if (law.knots.empty()) return report("its mass law has no knots", "at least one: mass, centre of mass, inertia");
  for (std::size_t i = 0; i < law.knots.size(); ++i) {
    const MassLaw::Knot& knot = law.knots[i];
    if (!std::isfinite(knot.at)) return report("its mass law has a knot that is not finite", "finite times or masses");
    if (i > 0 && !(knot.at > law.knots[i - 1].at))
      report("its mass law's knots do not increase: " + show(law.knots[i - 1].at) + ", " + show(knot.at),
             "each is later, or more has been burnt, than at the one before");
    if (!has_good_size(knot.mass)) report("its mass becomes " + show(knot.mass) + " kg at " + show(knot.at), kSizes);
    check.check_finite("law", knot.centre.allFinite());
    check_inertia(check, knot.inertia);
  }
  check.check_finite("law", law.exit.allFinite());
}

// Checks sizes, and that modal masses are 1: Σ m Φ_k·Φ_l is the trace of Σ m Φ_k Φ_lᵀ.
void check_flexible(const std::string& where, const FlexibleBody& body, ModelErrors& errors) {
  constexpr double kOrthonormal = 1e-3;  // modes of a lumped mass matrix; the kernel computes with the given sums
  const auto report = [&](const std::string& what, const std::string& mend) {
    errors.push_back({where, what, mend, "flexible"});
  };
  const Eigen::Index m = body.frequencies.size();
  const auto size = static_cast<std::size_t>(m);
  if (m == 0) return report("it is flexible without modes", "at least one mode, or a rigid body");
  if (body.damping.size() != m || body.momentum.cols() != m || body.first.size() != size ||
      body.second.size() != size * size || (body.initial.size() != 0 && body.initial.size() != m) ||
      (body.initial_rate.size() != 0 && body.initial_rate.size() != m))
    return report("its modes' numbers do not belong together", "as many of each as there are frequencies");
  bool finite = body.momentum.allFinite() && body.initial.allFinite() && body.initial_rate.allFinite();
  for (const std::vector<Eigen::Matrix3d>* list : {&body.first, &body.second})
    for (const Eigen::Matrix3d& matrix : *list) finite = finite && matrix.allFinite();
  if (!finite) return report("its modes have numbers that are not finite", "finite shapes");
  for (Eigen::Index k = 0; k < m; ++k) {
    if (!(body.frequencies[k] > 0) || !std::isfinite(body.frequencies[k]) || !(body.damping[k] >= 0) ||
        !std::isfinite(body.damping[k]))
      report("mode " + std::to_string(k + 1) + " has the frequency " + show(body.frequencies[k]) +
                 " rad/s and the damping " + show(body.damping[k]),
             "a frequency greater than 0, a damping of 0 or more");
    for (Eigen::Index l = 0; l < m; ++l) {
      const double mass = body.second[static_cast<std::size_t>(k * m + l)].trace();
      if (!(std::abs(mass - (k == l ? 1 : 0)) < kOrthonormal))
        return report(
            "the modal mass of modes " + std::to_string(k + 1) + " and " + std::to_string(l + 1) + " is " + show(mass),
            "mass-normalised modes: 1 for one mode, 0 for two");
    }
  }
}

void check_marker(const Model& model, const std::string& where, const Marker& marker, ModelErrors& errors) {
  const auto report = [&](const std::string& what, const std::string& mend) {
    errors.push_back({where, what, mend, "marker"});
  };
  if (!is_index(marker.body, model.bodies.size()) || !model.bodies[static_cast<std::size_t>(marker.body)].flexible)
    return report("it is the marker of no flexible body", "the index of a body with modes");
  const Eigen::Index m = model.bodies[static_cast<std::size_t>(marker.body)].flexible->frequencies.size();
  if (marker.shape.cols() != m || marker.turn.cols() != m)
    return report("its shapes are not as many as its body's modes", "a displacement and a rotation per mode");
  if (!marker.position.allFinite() || !marker.shape.allFinite() || !marker.turn.allFinite())
    report("its place or shapes are not finite", "finite values");
}

// Checks that joints of flexible bodies are at their markers.
void validate_attachments(const Model& model, ModelErrors& errors) {
  for (const Joint& joint : model.joints)
    for (const int body : {joint.base, joint.follower})
      if (is_index(body, model.bodies.size()) && model.bodies[static_cast<std::size_t>(body)].flexible)
        errors.push_back(
            {quoted("joint", joint.name),
             "it acts on the flexible body '" + model.bodies[static_cast<std::size_t>(body)].name + "' itself",
             "name one of its markers", "between"});
}

void validate_bodies(const Model& model, ModelErrors& errors) {
  constexpr double kShortest = 1e-6;  // a shorter quaternion does not determine an attitude
  if (model.bodies.empty()) errors.push_back({"model", "it has no bodies", "give at least one", "bodies"});
  if (model.bodies.size() > kMostBodies)
    errors.push_back({"model", "it has " + std::to_string(model.bodies.size()) + " bodies",
                      "give at most " + std::to_string(kMostBodies) + ": places are numbers of 32 bits", "bodies"});
  for (const Body& body : model.bodies) {
    const std::string where = quoted("body", body.name);
    const Check check{model, where, errors};
    if (body.law.has_value() + body.flexible.has_value() + body.marker.has_value() > 1)
      errors.push_back(
          {where, "it has more than one of a mass law, modes, and a body that carries it", "at most one", ""});
    if (body.marker) {
      check_marker(model, where, *body.marker, errors);
      continue;
    }
    if (body.flexible) check_flexible(where, *body.flexible, errors);
    if (!has_good_size(body.mass)) errors.push_back({where, "its mass is " + show(body.mass) + " kg", kSizes, "mass"});
    check_inertia(check, body.inertia);
    check.check_finite("position", body.p_WB.allFinite());
    check.check_finite("velocity", body.v_WB.allFinite());
    check.check_finite("rate", body.w_WB_B.allFinite());
    if (body.law) check_law(check, *body.law);
    const double length = body.q_WB.norm();
    if (!(length > kShortest) || !std::isfinite(length))
      errors.push_back(
          {where, "its attitude quaternion has the length " + show(length), "(w, x, y, z) of length 1", "attitude"});
  }
}

// --- Elements -------------------------------------------------------------------------------------------------------

void validate_elements(const Model& model, ModelErrors& errors) {
  for_each_kind([&](auto kind) {
    for (const auto& item : kind.of(model)) kind.validate(item, Check{model, quoted("element", item.name), errors});
  });
}

void validate_impulses(const Model& model, ModelErrors& errors) {
  for (std::size_t i = 0; i < model.impulses.size(); ++i) {
    const Impulse& impulse = model.impulses[i];
    const Check check{model, "impulse " + std::to_string(i + 1), errors};
    check.check_body(impulse.body, "body");
    check.check_finite("point", impulse.point.allFinite());
    check.check_finite("linear", impulse.linear.allFinite());
    check.check_finite("angular", impulse.angular.allFinite());
    check.check_channel(impulse.channel);
  }
}

// --- Channels, sensors, gravity -------------------------------------------------------------------------------------

void validate_channels(const Model& model, ModelErrors& errors) {
  for (const Channel& channel : model.channels) {
    const std::string where = quoted("channel", channel.name);
    const std::string range = "[" + show(channel.minimum) + ", " + show(channel.maximum) + "]";
    if (!std::isfinite(channel.minimum) || !std::isfinite(channel.maximum) || !(channel.minimum <= channel.maximum)) {
      errors.push_back({where, "its range is " + range, "[smallest, largest], finite", "range"});
      continue;
    }
    const auto check = [&](const char* key, double value) {
      if (!(channel.minimum <= value && value <= channel.maximum))
        errors.push_back({where, std::string(key) + " is " + show(value), "within its range " + range, key});
    };
    check("initial", channel.initial);
    check("safe", channel.safe);
  }
}

void validate_sensors(const Model& model, ModelErrors& errors) {
  for (const Sensor& sensor : model.sensors) {
    const std::string where = quoted("sensor", sensor.name);
    Check{model, where, errors}.check_finite("point", sensor.point.allFinite());
    if (sensor.kind != Sensor::Kind::kQuantity) {
      Quantity quantity = get_quantity(model, sensor);
      quantity.point.setZero();  // checked above, and not read by every kind
      check_quantity(model, quantity, false, where, "", errors);
    } else if (!is_index(sensor.subject, model.quantities.size())) {
      errors.push_back({where, "the quantity that it names does not exist", "the index of one quantity", "quantity"});
    }
  }
}

void validate_gravity(const Model& model, ModelErrors& errors) {
  const Check check{model, "gravity", errors};
  check.check_finite("uniform", model.gravity.uniform.allFinite());
  check.check_finite("centre", model.gravity.centre.allFinite());
  check.check_not_negative("mu", model.gravity.mu);
}

ModelErrors validate_placed(const Model& model) {
  ModelErrors errors;
  check_all_names(model, errors);
  validate_gravity(model, errors);
  validate_environment(model, errors);
  validate_bodies(model, errors);
  validate_channels(model, errors);
  validate_joints(model, errors);
  validate_elements(model, errors);
  validate_impulses(model, errors);
  validate_attachments(model, errors);
  validate_quantities(model, errors);
  validate_laws(model, errors);
  validate_sensors(model, errors);
  validate_surfaces(model, errors);
  validate_events(model, errors);
  return errors;
}

}  // namespace

std::vector<ModelError> validate(const Model& model) {
  if (has_markers(model)) return validate_placed(place_markers(model));
  return validate_placed(model);
}

}  // namespace unlatch
