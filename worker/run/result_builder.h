// From what a run measured to the two forms it is told in: the message for the service and the
// content of the result file. Both say the same.
#pragma once

#include "worker/run/run_record.h"
#include "worker/run/task.h"
#include "worker/storage/result_content.h"

namespace granary::run {

// What is known when the run has ended, well or not.
struct RunReport {
  std::string state = "complete";           // or "unstable"
  std::string message;                      // why it is unstable
  std::vector<core::ObservedValue> values;  // combined over replicates; empty when unstable
  std::string state_hash;
  core::EnergyLedger ledger;
  std::vector<std::string> warnings;
};

v1::Result result_message(const TaskSpec& spec, const RunRecord& record, const RunReport& report);
storage::ResultContent result_content(const TaskSpec& spec, const RunRecord& record,
                                      const RunReport& report, const v1::Result& message);

}  // namespace granary::run
