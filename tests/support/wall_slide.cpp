#include "tests/support/wall_slide.h"

#include <cmath>
#include <numbers>

namespace granary::test {
namespace {

constexpr double kAngleStep = 2e-5;  // rad = 1.1e-3 deg: how exactly onset and leaving are found

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

// One step of s'' = acceleration(t, s, s').
template <typename Acceleration>
SlideState runge_kutta(SlideState s, double t, double dt, const Acceleration& acceleration) {
  const double h = dt / 2;
  const double a1 = acceleration(t, s.place, s.speed);
  const double v2 = s.speed + h * a1, a2 = acceleration(t + h, s.place + h * s.speed, v2);
  const double v3 = s.speed + h * a2, a3 = acceleration(t + h, s.place + h * v2, v3);
  const double v4 = s.speed + dt * a3, a4 = acceleration(t + dt, s.place + dt * v3, v4);
  return {s.place + dt / 6 * (s.speed + 2 * v2 + 2 * v3 + v4),
          s.speed + dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)};
}

double sign_of(double speed) {
  return speed < 0 ? -1 : 1;
}

}  // namespace

double WallLine::inward_force(double theta, double speed) const {
  const double w = rotation_rate;
  return 2 * w * speed + w * w * distance - gravity * std::cos(alpha(theta));
}

SlideState slide_by_formula(const WallLine& wall, double theta, SlideState start, double time) {
  const double w = wall.rotation_rate, m = wall.outer ? -wall.friction : wall.friction;
  const double root = std::sqrt(1 + m * m), rate1 = w * (m + root), rate2 = w * (m - root);
  const double scale = wall.gravity / (2 * w * w * (1 + m * m));
  const auto particular = [&](double t) {
    const double a = wall.alpha(theta) + w * t;
    return SlideState{
        -m * wall.distance + scale * (-(1 - m * m) * std::sin(a) + 2 * m * std::cos(a)),
        scale * w * (-(1 - m * m) * std::cos(a) - 2 * m * std::sin(a))};
  };
  const SlideState p0 = particular(0), p = particular(time);
  const double place = start.place - p0.place, speed = start.speed - p0.speed;
  const double x = (speed - rate2 * place) / (rate1 - rate2), y = place - x;
  const double grow1 = x * std::exp(rate1 * time), grow2 = y * std::exp(rate2 * time);
  return {grow1 + grow2 + p.place, rate1 * grow1 + rate2 * grow2 + p.speed};
}

SlideEnd slide_from_rest(const WallLine& wall, double place, double tip_place, double theta_start) {
  const double w = wall.rotation_rate, dt = kAngleStep / w, side = wall.outer ? 1 : -1;
  const auto drive = [&](double theta, double s) {
    return w * w * s + wall.gravity * std::sin(wall.alpha(theta));
  };
  double theta = theta_start;
  while (drive(theta, place) <= wall.friction * std::abs(wall.inward_force(theta, 0)))
    theta += kAngleStep;
  SlideEnd end{.onset_deg = degrees(theta), .at_end = {place, 0}};
  const auto acceleration = [&](double t, double s, double v) {
    const double at = theta + w * t;
    return drive(at, s) - sign_of(v) * wall.friction * std::abs(wall.inward_force(at, v));
  };
  SlideState now{place, 0};
  while (true) {
    const SlideState next = runge_kutta(now, 0, dt, acceleration);
    theta += kAngleStep;
    end.at_tip = next.place >= tip_place;
    if (end.at_tip || side * wall.inward_force(theta, next.speed) < 0) {
      end.at_end = next;
      end.leaving_deg = degrees(theta);
      return end;
    }
    now = next;
  }
}

SlideEnd slide_on_path(const WallPath& path, double length, double rotation_rate, double friction,
                       double start_arc, double gravity) {
  const double w = rotation_rate, dt = kAngleStep / w;
  struct Forces {
    double along, inward;  // per mass
  };
  // Bucket coordinates turn clockwise with w: gravity turns counter-clockwise in them.
  const auto forces = [&](double theta, double s, double v) {
    const PathPoint p = path(s);
    const double gx = gravity * std::sin(theta), gy = -gravity * std::cos(theta);
    const double nx = p.tangent_y, ny = -p.tangent_x;  // to the axis side
    return Forces{
        w * w * (p.x * p.tangent_x + p.y * p.tangent_y) + gx * p.tangent_x + gy * p.tangent_y,
        p.curvature * v * v + 2 * w * v - w * w * (p.x * nx + p.y * ny) - (gx * nx + gy * ny)};
  };
  double theta = 0;
  while (forces(theta, start_arc, 0).along <=
         friction * std::abs(forces(theta, start_arc, 0).inward))
    theta += kAngleStep;
  SlideEnd end{.onset_deg = degrees(theta), .at_end = {start_arc, 0}};
  const auto acceleration = [&](double t, double s, double v) {
    const Forces f = forces(theta + w * t, s, v);
    return f.along - sign_of(v) * friction * std::abs(f.inward);
  };
  while (true) {
    end.at_end = runge_kutta(end.at_end, 0, dt, acceleration);
    theta += kAngleStep;
    end.at_tip = end.at_end.place >= length;
    if (end.at_tip || forces(theta, end.at_end.place, end.at_end.speed).inward < 0) {
      end.leaving_deg = degrees(theta);
      return end;
    }
  }
}

double spiral_speed_ratio(double psi, double friction) {
  const double cosine = std::cos(psi);
  return (-friction + cosine * std::sqrt(1 + friction * friction)) /
         (cosine + friction * std::sin(psi));
}

}  // namespace granary::test
