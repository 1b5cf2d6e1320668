// Scenes from the command line into one request: what `run`, `submit` and `check` share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "granary/v1/job.pb.h"
#include "proto/contract/resolve.h"

namespace granary::commands {

struct SubmissionOptions {
  std::vector<std::string> scenes;    // files, "-" = stdin
  std::vector<std::string> settings;  // path=value
  std::vector<std::string> tags;      // key=value
  std::vector<std::string> worker_tags;  // key=value
  std::int32_t priority = 0;
  std::string request_id;
  std::string time_limit;
  bool fresh = false;
};

// SCENE and --set; `check` needs no more.
void add_scene_options(CLI::App& verb, SubmissionOptions& options, bool many);
void add_submission_options(CLI::App& verb, SubmissionOptions& options);

struct LoadedScene {
  std::string source;  // file name, "<stdin>"
  v1::Scene scene;     // as written, with --set applied
  ResolvedScene resolved;
};

// Reads, parses, applies --set, validates and resolves every scene. The first error ends it, so
// nothing is sent when one scene is bad. Larger files than a scene may be are refused unread.
Result<std::vector<LoadedScene>> load_scenes(const SubmissionOptions& options);

// `default_threads` (0 = none) goes into scenes that do not say.
Result<v1::SubmitJobsRequest> make_request(const SubmissionOptions& options,
                                           std::uint32_t default_threads);

// A whole small file, "-" = stdin. The error names it.
Result<std::string> read_input(const std::string& path);

// Loads, then submits in one batch.
Result<std::vector<std::string>> submit_scenes(Context& context, const SubmissionOptions& options);

}  // namespace granary::commands
