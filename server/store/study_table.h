// StudyStore on SQLite: tables study, trial, price_point and effect_delta.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "server/studies/study_store.h"

namespace granary::server {

class StudyTable : public StudyStore {
 public:
  explicit StudyTable(SQLite::Database& connection);

  StudyId insert_study(const StudyRecord& study) override;
  std::optional<StudyRecord> find_study(StudyId id) override;
  std::optional<StudyId> find_study_request(const std::string& request_id) override;
  void update_study(const StudyRecord& study) override;
  std::vector<StudyRecord> list_studies(const std::string& kind, StudyId before,
                                        std::uint32_t limit) override;
  std::vector<StudyId> studies_in(v1::Study::State state) override;

  void insert_trial(const TrialRecord& trial) override;
  std::optional<TrialRecord> find_trial(StudyId study, std::uint32_t number) override;
  void update_trial(const TrialRecord& trial) override;
  std::vector<TrialRecord> trials_after(StudyId study, std::uint32_t number,
                                        std::uint32_t limit) override;
  void put_findings(StudyId study, const Findings& findings) override;

 private:
  void put_price(StudyId study, const std::vector<PricePoint>& points);
  void put_effects(StudyId study, const std::vector<EffectDelta>& deltas);
  void put_pareto(StudyId study, const std::vector<std::uint32_t>& numbers);

  SQLite::Database& connection_;
  SQLite::Statement insert_, find_, request_, update_, list_, in_state_;
  SQLite::Statement insert_trial_, update_trial_, trials_;
  SQLite::Statement clear_price_, put_price_, clear_effects_, put_effect_, clear_pareto_,
      put_pareto_;
};

}  // namespace granary::server
