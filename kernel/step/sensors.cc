#include "kernel/step/sensors.h"

#include "kernel/elements/contacts.h"
#include "kernel/elements/gravity.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

void write(double* out, const Vec3& a) {
  out[0] = a.x;
  out[1] = a.y;
  out[2] = a.z;
}

// Acceleration of a point fixed in the body, body axes, m/s²; `point`: body axes, from its origin, m. `g`, world axes,
// is taken away first: zero, or free fall for an accelerometer.
Vec3 calc_acceleration(const Evaluation& ev, int body, const Vec3& point, const Vec3& g) {
  const BodyKinematics k = read_kinematics(ev, body);
  const Spatial a = ev.get_acceleration(body);
  const Vec3 r = k.R * point;
  return transpose_times(k.R, (a.lin - g) + (cross(a.ang, r) + cross(k.w, cross(k.w, r))));
}

}  // namespace

void update_sensors(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  for (const PlanSensor& sensor : plan.sensors) {
    double* out = &ev.sensors[at(sensor.first)];
    const std::size_t subject = at(sensor.subject);
    switch (sensor.kind) {
      case Sensor::Kind::kPosition:
        write(out, state.bodies[subject].p);
        break;
      case Sensor::Kind::kAttitude: {
        const Quat& q = state.bodies[subject].q;
        out[0] = q.w;
        write(out + 1, {q.x, q.y, q.z});
        break;
      }
      case Sensor::Kind::kVelocity:
        write(out, state.bodies[subject].v);
        break;
      case Sensor::Kind::kRate:
        write(out, state.bodies[subject].w);
        break;
      case Sensor::Kind::kAcceleration:
        write(out, calc_acceleration(ev, sensor.subject, sensor.point, {0, 0, 0}));
        break;
      case Sensor::Kind::kSpecificForce: {
        const Vec3 point = state.bodies[subject].p + read_kinematics(ev, sensor.subject).R * sensor.point;
        write(out, calc_acceleration(ev, sensor.subject, sensor.point, calc_gravity(plan.gravity, point)));
        break;
      }
      case Sensor::Kind::kContact:
        out[0] = state.signals[subject] != 0 ? 1 : 0;
        break;
      case Sensor::Kind::kReaction:
        for (int r = 0; r < kRows; ++r) out[r] = ev.multipliers[subject * kRows + at(r)];
        break;
      case Sensor::Kind::kDisplacement:
      case Sensor::Kind::kAngle:
        out[0] = ev.coordinates[subject];
        break;
      case Sensor::Kind::kSpeed:
        out[0] = ev.speeds[subject];
        break;
      case Sensor::Kind::kDistance:
        out[0] = calc_shape_distance(plan, ev, sensor.subject, sensor.other);
        break;
    }
  }
}

}  // namespace unlatch
