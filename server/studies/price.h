// What accuracy costs: every rung of every ladder is a job with replicates; its error against the
// limit of the ladder, beside its CPU seconds. The cheapest rung that cannot be told from the
// finest one is the knee: what is dearer buys nothing that these replicates could show.
#pragma once

#include "server/studies/study_generator.h"

namespace granary::server {

Result<std::unique_ptr<StudyGenerator>> make_price(const v1::StudySpec& spec);

// Keys of StudySummary.figures, parts separated by '|':
//   knee|PATH                    value of the setting at the knee
//   order|PATH|OBSERVABLE        p of error ~ h^p; no value: below noise
//   limit|PATH|OBSERVABLE        extrapolated value, with its 95 % half-width
//   bias|RUNG|OBSERVABLE         value - limit, with the half-width of what noise could hide
//   memory|RUNG                  peak bytes of its process
inline constexpr char kFigureSeparator = '|';

// A rung's name in the view `price`: "chute.time_step_s=1e-05".
std::string rung_name(const std::string& path, double value);

}  // namespace granary::server
