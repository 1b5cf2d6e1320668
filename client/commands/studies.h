// What the verbs on studies share: names, rows and following one to its end.
#pragma once

#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "granary/v1/study.pb.h"

namespace granary::commands {

// "studies/3"; "3" too where only a study can be meant.
bool is_study_name(const std::string& text);
Result<std::string> study_name(const std::string& text);

render::Table study_table(const std::vector<v1::Study>& studies, render::Format format);
render::Table trial_table(const std::vector<v1::Trial>& trials, render::Format format);

// Follows a study until it has ended, progress on stderr (json: a line per change on stdout).
// 0 complete, 1 error, 7 cancelled, 130 after Ctrl-C: the study goes on.
Outcome follow_study(Context& context, const std::string& name, bool json_lines);

// Submits, prints the name; with `wait` follows it and prints its trials (one object a line in
// json).
Outcome submit_study(Context& context, v1::SubmitStudyRequest request, bool wait);

}  // namespace granary::commands
