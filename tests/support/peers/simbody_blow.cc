#include "tests/support/peers/simbody_blow.h"

#include <Simbody.h>

#include <cmath>

namespace unlatch::test {
namespace {

SimTK::Vec3 to_vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d to_eigen(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace

// Simbody combines k_i = E_i^(2/3) in series (HuntCrossleyForce.h): two equal ones give E / sqrt(8).
double calc_hertz_stiffness(const SphereBlow& blow) {
  const double radius = blow.radius[0] * blow.radius[1] / (blow.radius[0] + blow.radius[1]);
  return 4.0 / 3 * std::sqrt(radius) * blow.modulus / std::sqrt(8.0);
}

std::vector<SpherePlaces> run_simbody_blow(const SphereBlow& blow, double dt, int count) {
  constexpr double kAccuracy = 1e-11;  // of a step of Runge, Kutta and Merson
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter(system);
  SimTK::GeneralForceSubsystem forces(system);
  SimTK::GeneralContactSubsystem contacts(system);
  const SimTK::ContactSetIndex set = contacts.createContactSet();
  std::vector<SimTK::MobilizedBody> spheres;
  for (std::size_t i = 0; i < 2; ++i) {
    const SimTK::MassProperties mass(blow.mass[i], SimTK::Vec3(0), SimTK::Inertia(1));
    spheres.push_back(SimTK::MobilizedBody::Translation(matter.updGround(), SimTK::Transform(),
                                                        SimTK::Body::Rigid(mass), SimTK::Transform()));
    contacts.addBody(set, spheres[i], SimTK::ContactGeometry::Sphere(blow.radius[i]), SimTK::Transform());
  }
  SimTK::HuntCrossleyForce force(forces, contacts, set);
  for (int i = 0; i < 2; ++i)
    force.setBodyParameters(SimTK::ContactSurfaceIndex(i), blow.modulus, blow.dissipation, 0, 0, 0);
  SimTK::State state = system.realizeTopology();
  for (std::size_t i = 0; i < 2; ++i) {
    spheres[i].setQToFitTranslation(state, to_vec(blow.place[i]));
    spheres[i].setUToFitLinearVelocity(state, to_vec(blow.velocity[i]));
  }
  SimTK::RungeKuttaMersonIntegrator integrator(system);
  integrator.setAccuracy(kAccuracy);
  integrator.setMaximumStepSize(dt);
  SimTK::TimeStepper stepper(system, integrator);
  stepper.initialize(state);
  std::vector<SpherePlaces> motion;
  for (int tick = 1; tick <= count; ++tick) {
    stepper.stepTo(tick * dt);
    const SimTK::State& now = stepper.getState();
    system.realize(now, SimTK::Stage::Velocity);
    motion.push_back({to_eigen(spheres[0].getBodyOriginLocation(now)), to_eigen(spheres[1].getBodyOriginLocation(now)),
                      to_eigen(spheres[0].getBodyOriginVelocity(now)),
                      to_eigen(spheres[1].getBodyOriginVelocity(now))});
  }
  return motion;
}

}  // namespace unlatch::test
