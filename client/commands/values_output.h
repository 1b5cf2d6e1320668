// The values of jobs on stdout, in every format.
#pragma once

#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "granary/v1/job.pb.h"

namespace granary::commands {

// json: the contract's one line per job. table and csv: a row per observable.
Status write_values(Context& context, const std::vector<v1::GetValuesResponse>& responses);

// The same for jobs by name.
Status write_values_of(Context& context, const std::vector<std::string>& names);

}  // namespace granary::commands
