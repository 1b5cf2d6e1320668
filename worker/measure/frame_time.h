// Times of frames against times that a scene names.
#pragma once

namespace granary::measure {

// Times are step numbers times the step: they miss what they stand for by some ulp, relative.
inline constexpr double kTimeRounding = 1e-12;

// A frame from here on is not before `time`; one up to the other is not after it.
inline double earliest_of(double time) {
  return time * (1 - kTimeRounding);
}
inline double latest_of(double time) {
  return time * (1 + kTimeRounding);
}

}  // namespace granary::measure
