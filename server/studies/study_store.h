// What studies need to be kept, and nothing more. server/store implements it on SQLite. All calls
// of one request happen inside one transaction of the owner thread; a call that cannot be done
// throws.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/studies/study_generator.h"
#include "server/studies/study_records.h"

namespace granary::server {

class StudyStore {
 public:
  virtual ~StudyStore() = default;

  virtual StudyId insert_study(const StudyRecord& study) = 0;
  virtual std::optional<StudyRecord> find_study(StudyId id) = 0;
  virtual std::optional<StudyId> find_study_request(const std::string& request_id) = 0;
  virtual void update_study(const StudyRecord& study) = 0;  // state, generator, counters, summary
  // Newest first, without spec and generator; `before` 0 = from the newest, kind "" = any.
  virtual std::vector<StudyRecord> list_studies(const std::string& kind, StudyId before,
                                                std::uint32_t limit) = 0;
  virtual std::vector<StudyId> studies_in(v1::Study::State state) = 0;

  virtual void insert_trial(const TrialRecord& trial) = 0;
  virtual std::optional<TrialRecord> find_trial(StudyId study, std::uint32_t number) = 0;
  virtual void update_trial(const TrialRecord& trial) = 0;  // told, judgement
  virtual std::vector<TrialRecord> trials_after(StudyId study, std::uint32_t number,
                                                std::uint32_t limit) = 0;
  virtual void put_findings(StudyId study, const Findings& findings) = 0;  // replaces
};

}  // namespace granary::server
