// `granary-worker --scene FILE`: one scene, no server. Values on stdout, everything else on stderr.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/run/task_setup.h"

namespace granary::run {

struct ConsoleOptions {
  std::string scene_file;                                     // "-" reads stdin
  std::vector<std::pair<std::string, std::string>> settings;  // --set path=value
  std::string output_file;  // HDF5 result; empty: nothing is stored
  bool json = false;        // else a table
  std::optional<std::uint32_t> threads;
  bool profile = false;  // seconds per phase of a step, on stderr
  bool quiet = false;    // no progress
};

// Runs it and returns the exit code of PRODUCT section 2. Interrupted with an output file it leaves
// a checkpoint in OUTPUT.parts/, and the same command goes on from there.
int run_console(const ConsoleOptions& options, const EngineBuild& build);

// `granary-worker --verify FILE`: what is wrong with it on stderr, exit code 0 or 9.
int verify_console(const std::string& file);

// `granary-worker --salvage DIR -o FILE`: keeps the frames of a run that nobody will resume.
int salvage_console(const std::string& directory, const std::string& output_file);

}  // namespace granary::run
