// One bead that slides, without rolling, along a wall of the turning bucket: Eq. 10 of the
// bucket-elevator paper with the sign that PHYSICS A5 corrects, and an independent integration of
// the equation of motion. The bead is a point; callers move the wall by the disk's radius.
//
// r = distance of the wall's line from the axis; S = place along the line from the foot of the
// perpendicular, positive in the direction of rotation; alpha = angle of that perpendicular from
// the vertical in the rotation sense; N = 2 w S' + w^2 r - g cos(alpha) = force per mass towards
// the axis: an outer wall can give N > 0, an inner wall N < 0.
#pragma once

#include <functional>
#include <optional>

namespace granary::test {

struct SlideState {
  double place = 0;  // S [m]
  double speed = 0;  // S' [m/s], relative to the wall
};

struct WallLine {
  double distance = 0.5;     // r [m]
  double alpha_start = 0;    // rad, alpha at theta = 0
  double rotation_rate = 0;  // w [rad/s]
  double friction = 0;       // mu
  bool outer = true;
  double gravity = 9.81;

  double alpha(double theta) const { return alpha_start + theta; }
  double inward_force(double theta, double speed) const;  // N [m/s2]
};

// Eq. 10 for a bead that slides forward: state after `time` from `start` at angle `theta`.
SlideState slide_by_formula(const WallLine& wall, double theta, SlideState start, double time);

struct SlideEnd {
  double onset_deg = 0;    // theta at which the bead starts to move
  double leaving_deg = 0;  // theta at which it passes the tip or loses the wall
  SlideState at_end;
  bool at_tip = false;
};

// A bead at rest at `place` until friction lets go, then by Runge-Kutta until the tip (`tip_place`)
// or the loss of contact; starts at theta = `theta_start` (rad).
SlideEnd slide_from_rest(const WallLine& wall, double place, double tip_place,
                         double theta_start = 0);

// The same on a curved outer wall, given by the path of the bead's centre in bucket coordinates
// (world coordinates at theta = 0) over its arc length.
struct PathPoint {
  double x = 0, y = 0;  // m
  double tangent_x = 0, tangent_y = 0;
  double curvature = 0;  // 1/m, > 0 where the path bends towards the axis side of the wall
};
using WallPath = std::function<PathPoint(double arc)>;
SlideEnd slide_on_path(const WallPath& path, double length, double rotation_rate, double friction,
                       double start_arc, double gravity = 9.81);

// Speed over w R of the self-similar slide on a logarithmic spiral at angle psi to the radius.
double spiral_speed_ratio(double psi, double friction);

}  // namespace granary::test
