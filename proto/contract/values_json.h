// The stable json of a job's values: one compact line (PRODUCT section 2).
#pragma once

#include <string>

#include "granary/v1/job.pb.h"

namespace granary {

std::string values_json(const v1::GetValuesResponse& response);

}  // namespace granary
