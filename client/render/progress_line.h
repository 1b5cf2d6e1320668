// Progress as text: what `watch` and `run` show while a job runs. No terminal control here.
#pragma once

#include <string>
#include <vector>

#include "granary/v1/job.pb.h"

namespace granary::render {

// "[#######.......]  47 %  rotation  t 0.81/1.72 s  ETA 0:12  700 particles  1650 contacts
//  12.3 ns/particle-step  f1_m 1.92  ledger 1.2e-06". Fractions outside [0, 1] are clamped; what
//  the
// engine did not report is left out.
std::string progress_line(const v1::Progress& progress);

// The same broken between segments into lines of at most `width` columns (a longer segment is cut).
std::vector<std::string> progress_lines(const v1::Progress& progress, std::size_t width);

// "####......" of `width` characters. Full only at fraction 1.
std::string bar(double fraction, std::size_t width);

// 12 -> "0:12", 3725 -> "1:02:05", 90000 -> "1d 1:00:00".
std::string clock_text(double duration_s);

}  // namespace granary::render
