// What price and ablate share: one scene into the request for a study, and following it to its end.
#pragma once

#include <string>

#include "client/commands/command_line.h"
#include "client/commands/submission.h"
#include "granary/v1/study.pb.h"

namespace granary::commands {

// The scene of `options` with tags, priority, time limit and freshness; the kind is left to the
// caller.
Result<v1::SubmitStudyRequest> study_request(Context& context, const SubmissionOptions& options);

// Submits, follows to the end, progress on stderr; the study as it ended, or nothing after Ctrl-C.
Result<std::optional<v1::Study>> run_study(Context& context, v1::SubmitStudyRequest request);

}  // namespace granary::commands
