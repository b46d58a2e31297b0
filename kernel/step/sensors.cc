#include "kernel/step/sensors.h"

#include "kernel/dynamics/forces.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void write(double* out, const Vec3& a) {
  out[0] = a.x;
  out[1] = a.y;
  out[2] = a.z;
}

// Of a point fixed in the body, body axes; `g` is taken away first: zero, or free fall for an accelerometer.
Vec3 calc_acceleration(const Workspace& ws, int body, const Vec3& point, const Vec3& g) {
  const BodyKinematics k = ws.kinematics[at(body)];
  const Spatial a = ws.accelerations[at(body)];
  const Vec3 r = k.R * point;
  return transpose_times(k.R, (a.lin - g) + (cross(a.ang, r) + cross(k.w, cross(k.w, r))));
}

}  // namespace

void update_sensors(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (const PlanSensor& sensor : plan.sensors) {
    double* out = &ws.sensors[at(sensor.first)];
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
        write(out, calc_acceleration(ws, sensor.subject, sensor.point, {0, 0, 0}));
        break;
      case Sensor::Kind::kSpecificForce: {
        const Vec3 point = state.bodies[subject].p + ws.kinematics[subject].R * sensor.point;
        write(out, calc_acceleration(ws, sensor.subject, sensor.point, calc_gravity(plan, point)));
        break;
      }
      case Sensor::Kind::kContact:
        out[0] = state.signals[subject] != 0 ? 1 : 0;
        break;
      case Sensor::Kind::kReaction:
        for (int r = 0; r < kRows; ++r) out[r] = ws.multipliers[subject * kRows + at(r)];
        break;
      case Sensor::Kind::kDisplacement:
      case Sensor::Kind::kAngle:
        out[0] = ws.coordinates[subject];
        break;
      case Sensor::Kind::kSpeed:
        out[0] = ws.speeds[subject];
        break;
    }
  }
}

}  // namespace unlatch
