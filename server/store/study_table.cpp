#include "server/store/study_table.h"

#include "server/store/statement_use.h"

namespace granary::server {
namespace {

const std::string kStudyColumns =
    "id, kind, name, state, owner, request_id, submitted_ms, ended_ms, planned, trials, told, "
    "failed, "
    "reused, message, summary";
const std::string kTrialColumns =
    "study, number, job, label, role, candidate, inputs, error, told, objective, objective_error, "
    "feasible, best_objective, pareto";

StudyRecord read_study(SQLite::Statement& row) {
  StudyRecord study;
  int i = 0;
  study.id = row.getColumn(i++).getInt64();
  study.kind = row.getColumn(i++).getString();
  study.name = row.getColumn(i++).getString();
  study.state = static_cast<v1::Study::State>(row.getColumn(i++).getInt());
  study.owner = row.getColumn(i++).getString();
  study.request_id = row.getColumn(i++).getString();
  study.submitted_ms = row.getColumn(i++).getInt64();
  study.ended_ms = row.getColumn(i++).getInt64();
  study.planned = row.getColumn(i++).getUInt();
  study.trials = row.getColumn(i++).getUInt();
  study.told = row.getColumn(i++).getUInt();
  study.failed = row.getColumn(i++).getUInt();
  study.reused = row.getColumn(i++).getUInt();
  study.message = row.getColumn(i++).getString();
  study.summary.ParseFromString(row.getColumn(i++).getString());
  if (row.getColumnCount() > i) {
    study.spec_bytes = row.getColumn(i++).getString();
    study.generator_bytes = row.getColumn(i++).getString();
  }
  return study;
}

std::optional<double> real_or_nothing(const SQLite::Column& column) {
  return column.isNull() ? std::nullopt : std::optional(column.getDouble());
}

TrialRecord read_trial(SQLite::Statement& row) {
  TrialRecord trial;
  int i = 0;
  trial.study = row.getColumn(i++).getInt64();
  trial.number = row.getColumn(i++).getUInt();
  trial.job = row.getColumn(i++).getInt64();
  trial.label = row.getColumn(i++).getString();
  trial.role = row.getColumn(i++).getString();
  trial.candidate = row.getColumn(i++).getUInt();
  trial.inputs = row.getColumn(i++).getString();
  trial.error = row.getColumn(i++).getString();
  trial.told = row.getColumn(i++).getInt() != 0;
  trial.objective = real_or_nothing(row.getColumn(i++));
  trial.objective_error = real_or_nothing(row.getColumn(i++));
  if (const auto feasible = row.getColumn(i++); !feasible.isNull())
    trial.feasible = feasible.getInt() != 0;
  trial.best_objective = real_or_nothing(row.getColumn(i++));
  trial.pareto = row.getColumn(i++).getInt() != 0;
  return trial;
}

void bind(SQLite::Statement& row, int index, const std::optional<double>& value) {
  if (value) row.bind(index, *value);
}

void bind_blob(SQLite::Statement& row, int index, const std::string& bytes) {
  row.bind(index, bytes.data(), static_cast<int>(bytes.size()));
}

}  // namespace

StudyTable::StudyTable(SQLite::Database& c)
    : connection_(c),
      insert_(c,
              "INSERT INTO study (kind, name, state, owner, request_id, spec, generator, "
              "submitted_ms, planned) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      find_(c, "SELECT " + kStudyColumns + ", spec, generator FROM study WHERE id = ?"),
      request_(c, "SELECT id FROM study WHERE request_id = ?"),
      update_(
          c,
          "UPDATE study SET state = ?, ended_ms = ?, planned = ?, trials = ?, told = ?, failed = "
          "?, reused = ?, message = ?, summary = ?, generator = ?, best_trial = ?, "
          "best_objective = ?, best_objective_error = ? WHERE id = ?"),
      list_(c, "SELECT " + kStudyColumns +
                   " FROM study WHERE (?1 = '' OR kind = ?1) AND (?2 = 0 OR id < ?2) "
                   "ORDER BY id DESC LIMIT ?3"),
      in_state_(c, "SELECT id FROM study WHERE state = ? ORDER BY id"),
      insert_trial_(c,
                    "INSERT INTO trial (study, number, job, label, role, candidate, inputs, error) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?)"),
      update_trial_(c,
                    "UPDATE trial SET told = ?, objective = ?, objective_error = ?, feasible = ?, "
                    "best_objective = ? WHERE study = ? AND number = ?"),
      trials_(c, "SELECT " + kTrialColumns +
                     " FROM trial WHERE study = ? AND number > ? ORDER BY number LIMIT ?"),
      clear_price_(c, "DELETE FROM price_point WHERE study = ?"),
      put_price_(c,
                 "INSERT INTO price_point (study, job, rung, observable, value, error, cpu_s) "
                 "VALUES (?, ?, ?, ?, ?, ?, ?)"),
      clear_effects_(c, "DELETE FROM effect_delta WHERE study = ?"),
      put_effect_(c,
                  "INSERT INTO effect_delta (study, effect, observable, delta, error, cpu_ratio) "
                  "VALUES (?, ?, ?, ?, ?, ?)"),
      clear_pareto_(c, "UPDATE trial SET pareto = 0 WHERE study = ? AND pareto = 1"),
      put_pareto_(c, "UPDATE trial SET pareto = 1 WHERE study = ? AND number = ?") {}

StudyId StudyTable::insert_study(const StudyRecord& study) {
  Use row(insert_);
  row->bind(1, study.kind);
  row->bind(2, study.name);
  row->bind(3, static_cast<int>(study.state));
  row->bind(4, study.owner);
  row->bind(5, study.request_id);
  bind_blob(insert_, 6, study.spec_bytes);
  bind_blob(insert_, 7, study.generator_bytes);
  row->bind(8, study.submitted_ms);
  row->bind(9, study.planned);
  row->exec();
  return connection_.getLastInsertRowid();
}

std::optional<StudyRecord> StudyTable::find_study(StudyId id) {
  Use row(find_);
  row->bind(1, id);
  if (!row->executeStep()) return {};
  return read_study(find_);
}

std::optional<StudyId> StudyTable::find_study_request(const std::string& request_id) {
  Use row(request_);
  row->bind(1, request_id);
  if (!row->executeStep()) return {};
  return row->getColumn(0).getInt64();
}

void StudyTable::update_study(const StudyRecord& study) {
  Use row(update_);
  int i = 1;
  row->bind(i++, static_cast<int>(study.state));
  row->bind(i++, study.ended_ms);
  row->bind(i++, study.planned);
  row->bind(i++, study.trials);
  row->bind(i++, study.told);
  row->bind(i++, study.failed);
  row->bind(i++, study.reused);
  row->bind(i++, study.message);
  bind_blob(update_, i++, study.summary.SerializeAsString());
  bind_blob(update_, i++, study.generator_bytes);
  const v1::StudySummary& best = study.summary;
  if (best.has_best_trial()) row->bind(i, best.best_trial());
  if (best.has_best_objective()) row->bind(i + 1, best.best_objective());
  if (best.has_best_objective_error()) row->bind(i + 2, best.best_objective_error());
  row->bind(i + 3, study.id);
  row->exec();
}

std::vector<StudyRecord> StudyTable::list_studies(const std::string& kind, StudyId before,
                                                  std::uint32_t limit) {
  Use row(list_);
  row->bind(1, kind);
  row->bind(2, before);
  row->bind(3, limit);
  std::vector<StudyRecord> studies;
  while (row->executeStep()) studies.push_back(read_study(list_));
  return studies;
}

std::vector<StudyId> StudyTable::studies_in(v1::Study::State state) {
  Use row(in_state_);
  row->bind(1, static_cast<int>(state));
  std::vector<StudyId> ids;
  while (row->executeStep()) ids.push_back(row->getColumn(0).getInt64());
  return ids;
}

void StudyTable::insert_trial(const TrialRecord& trial) {
  Use row(insert_trial_);
  row->bind(1, trial.study);
  row->bind(2, trial.number);
  row->bind(3, trial.job);
  row->bind(4, trial.label);
  row->bind(5, trial.role);
  row->bind(6, trial.candidate);
  row->bind(7, trial.inputs);
  row->bind(8, trial.error);
  row->exec();
}

void StudyTable::update_trial(const TrialRecord& trial) {
  Use row(update_trial_);
  row->bind(1, trial.told ? 1 : 0);
  bind(update_trial_, 2, trial.objective);
  bind(update_trial_, 3, trial.objective_error);
  if (trial.feasible) row->bind(4, *trial.feasible ? 1 : 0);
  bind(update_trial_, 5, trial.best_objective);
  row->bind(6, trial.study);
  row->bind(7, trial.number);
  row->exec();
}

std::vector<TrialRecord> StudyTable::trials_after(StudyId study, std::uint32_t number,
                                                  std::uint32_t limit) {
  Use row(trials_);
  row->bind(1, study);
  row->bind(2, number);
  row->bind(3, limit);
  std::vector<TrialRecord> trials;
  while (row->executeStep()) trials.push_back(read_trial(trials_));
  return trials;
}

std::optional<TrialRecord> StudyTable::find_trial(StudyId study, std::uint32_t number) {
  const auto found = trials_after(study, number - 1, 1);
  if (found.empty() || found[0].number != number) return {};
  return found[0];
}

void StudyTable::put_findings(StudyId study, const Findings& findings) {
  put_price(study, findings.price);
  put_effects(study, findings.effects);
  put_pareto(study, findings.pareto);
}

void StudyTable::put_price(StudyId study, const std::vector<PricePoint>& points) {
  Use clear(clear_price_);
  clear->bind(1, study);
  clear->exec();
  for (const PricePoint& point : points) {
    Use row(put_price_);
    row->bind(1, study);
    row->bind(2, job_id_from(point.job).value_or(0));
    row->bind(3, point.rung);
    row->bind(4, point.observable);
    bind(put_price_, 5, point.value);
    bind(put_price_, 6, point.error);
    bind(put_price_, 7, point.cpu_s);
    row->exec();
  }
}

void StudyTable::put_effects(StudyId study, const std::vector<EffectDelta>& deltas) {
  Use clear(clear_effects_);
  clear->bind(1, study);
  clear->exec();
  for (const EffectDelta& delta : deltas) {
    Use row(put_effect_);
    row->bind(1, study);
    row->bind(2, delta.effect);
    row->bind(3, delta.observable);
    bind(put_effect_, 4, delta.delta);
    bind(put_effect_, 5, delta.error);
    bind(put_effect_, 6, delta.cpu_ratio);
    row->exec();
  }
}

void StudyTable::put_pareto(StudyId study, const std::vector<std::uint32_t>& numbers) {
  Use clear(clear_pareto_);
  clear->bind(1, study);
  clear->exec();
  for (const std::uint32_t number : numbers) {
    Use row(put_pareto_);
    row->bind(1, study);
    row->bind(2, number);
    row->exec();
  }
}

}  // namespace granary::server
