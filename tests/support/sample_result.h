// A small result file with something in every part of the layout.
#pragma once

#include <filesystem>

#include "worker/storage/result_writer.h"

namespace granary::testing {

storage::ResultContent sample_content();
void write_sample_result(const std::filesystem::path& path);

}  // namespace granary::testing
