// Series of a result, thinned for the database: what `granary query` shows as the view `series`.
#pragma once

#include <span>

#include "granary/v1/result.pb.h"
#include "worker/core/simulation.h"

namespace granary::run {

inline constexpr std::size_t kMaxSeriesRows = 200;

// Tables with a "time_s" column; every k-th row with the last one, so that at most kMaxSeriesRows
// remain. Values as float: seven digits are more than their error bars need.
v1::SeriesList series_message(std::span<const core::Table> tables);

}  // namespace granary::run
