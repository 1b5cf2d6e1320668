// `granary-worker --export-history FILE -o OUT.h5`: a study's history (v1.StudyHistory, written by
// the client) as an HDF5 file.
#pragma once

#include <string>

namespace granary::run {

// Exit code 0, 2 (not writable) or 9 (not a history).
int history_console(const std::string& input_file, const std::string& output_file);

}  // namespace granary::run
