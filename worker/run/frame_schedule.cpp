#include "worker/run/frame_schedule.h"

#include <cmath>
#include <limits>

namespace granary::run {
namespace {

double interval_of(const v1::Output& output, double end_time_s) {
  if (output.has_frame_interval_s()) return output.frame_interval_s();
  const double count = output.has_frames() ? output.frames() : kDefaultFrameCount;
  const bool end_is_known = std::isfinite(end_time_s) && end_time_s > 0;
  return count > 0 && end_is_known ? end_time_s / count : 0;
}

}  // namespace

void FrameSchedule::update(double time_s, double end_time_s) {
  if (state_.started || time_s < 0) return;
  state_.started = true;
  state_.interval_s = interval_of(output_, end_time_s);
  state_.next_time_s = 0;
  // Half an interval of slack: the last multiple may come out a rounding error beyond the end.
  state_.last_due_s = output_.has_frame_interval_s() ? std::numeric_limits<double>::infinity()
                                                     : end_time_s + 0.5 * state_.interval_s;
}

bool FrameSchedule::due(double time_s) const {
  return state_.started && state_.interval_s > 0 && time_s >= state_.next_time_s &&
         state_.next_time_s <= state_.last_due_s;
}

double FrameSchedule::limit_s() const {
  if (!state_.started) return 0;  // stop exactly where the main phase begins
  const bool more = state_.interval_s > 0 && state_.next_time_s <= state_.last_due_s;
  return more ? state_.next_time_s : std::numeric_limits<double>::infinity();
}

void FrameSchedule::taken(double time_s) {
  ++state_.next_index;
  state_.last_time_s = time_s;
  double multiple = std::floor(time_s / state_.interval_s) + 1;
  while (multiple * state_.interval_s <= time_s) ++multiple;  // the quotient may round down
  state_.next_time_s = multiple * state_.interval_s;
}

bool FrameSchedule::final_frame_due(double time_s) const {
  return state_.started && state_.interval_s > 0 && time_s > state_.last_time_s &&
         time_s <= state_.last_due_s;
}

}  // namespace granary::run
