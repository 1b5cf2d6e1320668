#include "worker/run/frame_keeper.h"

#include <algorithm>

#include "worker/run/cost_clock.h"

namespace granary::run {

bool FrameKeeper::keep_due(WatchedEngine& engine) {
  const core::SimulationProgress& now = engine.now();
  schedule_.update(now.time_s, now.end_time_s);
  return !schedule_.due(now.time_s) || keep(engine);
}

bool FrameKeeper::keep_last(WatchedEngine& engine) {
  if (!keep_due(engine)) return false;
  return !schedule_.final_frame_due(engine.now().time_s) || keep(engine);
}

bool FrameKeeper::keep(WatchedEngine& engine) {
  const AddedCpuTime timer(output_cpu_s_);
  const std::vector<core::ColumnView> columns = wanted(engine.simulation().frame());
  if (!engine.accepts(columns)) return false;
  const core::SimulationProgress& now = engine.now();
  storage_.append_frame({schedule_.state().next_index, now.time_s, now.phase, columns});
  schedule_.taken(now.time_s);
  return true;
}

std::vector<core::ColumnView> FrameKeeper::wanted(std::vector<core::ColumnView> columns) const {
  const auto& names = output_.fields();
  if (!names.empty())
    std::erase_if(columns, [&](const core::ColumnView& column) {
      return std::find(names.begin(), names.end(), column.name) == names.end();
    });
  return columns;
}

}  // namespace granary::run
