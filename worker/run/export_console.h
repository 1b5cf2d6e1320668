// `granary-worker --export-csv FILE -o DIRECTORY`: a result file as tables.
#pragma once

#include <string>

namespace granary::run {

// File names on stdout, one a line. Exit code 0, 2 (not writable) or 9 (no intact result file).
int export_console(const std::string& input_file, const std::string& directory);

}  // namespace granary::run
