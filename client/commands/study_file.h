// Study files: a granary.v1.StudySpec as protobuf text or JSON. `scene_file` names a scene beside
// it.
#pragma once

#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "granary/v1/study.pb.h"

namespace granary::commands {

struct StudyFileOptions {
  std::string path;                   // "-" = stdin
  std::vector<std::string> settings;  // --set, for the scene, behind the file's own
};

void add_study_file_options(CLI::App& verb, StudyFileOptions& options);

// Parsed strictly, its scene read and set; ready to be sent.
Result<v1::StudySpec> load_study(const StudyFileOptions& options);

}  // namespace granary::commands
