// `granary-worker --export FILE --to csv|svg -o DIRECTORY`: a result file in other forms.
#pragma once

#include <string>

namespace granary::run {

// File names on stdout, one a line. Exit code 0, 2 (not writable) or 9 (no intact result file).
int export_console(const std::string& input_file, const std::string& form,
                   const std::string& directory);

}  // namespace granary::run
