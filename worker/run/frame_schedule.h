// When frames are taken: at multiples of an interval of simulated time in the main phase (time >=
// 0; filling runs at negative time), plus the final state. A count of frames covers the main phase:
// what an engine computes after its end time (grains flying on to where they land) gets frames only
// when the scene names an interval. Depends on nothing but the scene and the engine's clock, so a
// resumed run takes the same frames.
#pragma once

#include <cstdint>

#include "granary/v1/scene.pb.h"

namespace granary::run {

constexpr int kDefaultFrameCount = 100;  // over the main phase

class FrameSchedule {
 public:
  struct State {
    bool started = false;
    double interval_s = 0;  // 0 = no frames; known once the main phase has started
    double last_due_s = 0;  // no frame is due after it
    std::uint64_t next_index = 0;
    double next_time_s = 0;
    double last_time_s = -1;
  };

  explicit FrameSchedule(const v1::Output& output) : output_(output) {}

  // To be called after every chunk. At the start of the main phase the interval is fixed: the end
  // of the run may only be known then (a rotation rate that follows from the filling).
  void update(double time_s, double end_time_s);
  bool due(double time_s) const;
  // The engine is not to run past this time before asking again; infinity when there is none.
  double limit_s() const;
  void taken(double time_s);
  bool final_frame_due(double time_s) const;  // the last state is kept, if it has not been

  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  v1::Output output_;
  State state_;
};

}  // namespace granary::run
