#include "server/store/query_views.h"

#include <algorithm>
#include <map>

#include "proto/contract/scene_rules.h"

namespace granary::server {
namespace {

using Columns = std::vector<ViewColumnText>;

const std::vector<ValueName>& documented_discharge_values() {
  static const std::vector<ValueName> values = {{"f1_m", "m"},
                                                {"f2_m", "m"},
                                                {"f3_percent", "%"},
                                                {"f4_m", "m"},
                                                {"f1_landing_m", "m"},
                                                {"f4_landing_m", "m"},
                                                {"target_percent", "%"},
                                                {"leg_percent", "%"},
                                                {"a5_deg", "deg"},
                                                {"a50_deg", "deg"},
                                                {"a95_deg", "deg"},
                                                {"fill_ratio", "1"},
                                                {"count_initial", "1"},
                                                {"filled_mass_kg", "kg"},
                                                {"discharged_mass_kg", "kg"},
                                                {"rademacher_ka", "1"}};
  return values;
}

const std::vector<ValueName>& documented_chute_values() {
  static const std::vector<ValueName> values = {{"particle_count", "1"},
                                                {"mass_flow_kg_per_s", "kg/s"},
                                                {"exit_speed_m_per_s", "m/s"},
                                                {"steady_from_s", "s"}};
  return values;
}

// A value column holds two per name; SQLite allows 2,000 columns in all.
constexpr std::size_t kMaxValues = 500;

std::vector<ValueName> merged(std::vector<ValueName> values, const std::vector<ValueName>& seen) {
  for (const ValueName& value : seen) {
    if (values.size() == kMaxValues) break;
    if (std::none_of(values.begin(), values.end(),
                     [&](const ValueName& known) { return known.name == value.name; }))
      values.push_back(value);
  }
  return values;
}

std::string time_text(const std::string& ms) {
  return "CASE WHEN " + ms + " > 0 THEN strftime('%Y-%m-%dT%H:%M:%fZ', " + ms +
         " / 1000.0, 'unixepoch') END";
}

// The same spelling as in the expression indexes, which these columns are found by.
std::string job_text(const std::string& id) {
  return "'jobs/' || " + id;
}

std::string job_text_or_null(const std::string& id) {
  return job_text("nullif(" + id + ", 0)");
}

const char* const kJobState =
    "CASE j.state WHEN 1 THEN 'waiting' WHEN 2 THEN 'running' WHEN 3 THEN 'complete' WHEN 4 THEN "
    "'error' WHEN 5 THEN 'unstable' WHEN 6 THEN 'cancelled' END";

Columns job_identity() {
  return {{"job", job_text("j.id"), "name of the job"},
          {"state", kJobState, "waiting, running, complete, error, unstable or cancelled"}};
}

std::string cost(const char* column) {
  return std::string("(SELECT c.") + column + " FROM job_cost c WHERE c.job = j.id)";
}

ViewText jobs_view() {
  ViewText view{"jobs", "every job", "job j", job_identity()};
  const Columns more = {
      {"kind", "j.kind", "discharge or chute"},
      {"priority", "j.priority", "higher runs first"},
      {"owner", "j.owner", "who submitted it"},
      {"study", "CASE WHEN j.study > 0 THEN 'studies/' || j.study END", "the study that made it"},
      {"key", "j.key", "hash of the resolved scene and the engine version"},
      {"submitted", time_text("j.submitted_ms"), "UTC"},
      {"started", time_text("j.started_ms"), "UTC, of the first execution"},
      {"ended", time_text("j.ended_ms"), "UTC"},
      {"attempts", "j.attempts", "executions"},
      {"worker", "nullif(j.worker, '')", "of the last execution"},
      {"error", "nullif(j.error, '')", "why it failed"},
      {"timed_out", "j.timed_out", "1 when its time limit ended it"},
      {"reused", "j.reused", "1 when a stored result answered it"},
      {"time_limit_s", "nullif(j.time_limit_s, 0)", "as submitted"},
      {"tags", "(SELECT json_group_object(t.name, t.value) FROM job_tag t WHERE t.job = j.id)",
       "JSON object; json_extract(tags, '$.name')"},
      {"result_sha256", "nullif(j.result_sha256, '')", "of the HDF5 file"},
      {"result_size_bytes", "nullif(j.result_bytes, 0)", "of the HDF5 file"},
      {"wall_s", cost("wall_s"), "time from start to end of the engine"},
      {"cpu_s", cost("cpu_s"), "CPU time, filling included"},
      {"reused_s", cost("reused_s"), "part of cpu_s that a stored filling saved"},
      {"steps", cost("steps"), "time steps"},
      {"particle_steps", cost("particle_steps"), "free particles times steps"},
      {"ns_per_particle_step", cost("ns_per_particle_step"), "price of one particle's step"},
      {"contacts_per_particle", cost("contacts_per_particle"), "mean over the run"},
      {"threads", cost("threads"), "of the engine"},
      {"peak_rss_bytes", cost("peak_rss_bytes"), "largest memory of the engine"},
      {"remainder_ratio", cost("remainder_ratio"),
       "energy the ledger cannot explain / turned over"}};
  view.columns.insert(view.columns.end(), more.begin(), more.end());
  return view;
}

std::string quoted(const std::string& text) {
  return "'" + text + "'";  // names of ours or checked by is_plain: no quotes inside
}

bool is_plain(const std::string& name) {
  return !name.empty() && name.size() <= 100 &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

void add_values(const std::vector<ValueName>& values, Columns& columns) {
  for (const ValueName& value : values) {
    if (!is_plain(value.name)) continue;
    columns.push_back({value.name, "job_value(j.id, " + quoted(value.name) + ")", "value [" + value.unit + "]"});
    columns.push_back({error_column(value), "job_error(j.id, " + quoted(value.name) + ")",
                       "half-width of its 95 % interval; NULL = unknown"});
  }
}

void add_scene_fields(const std::string& kind, Columns& columns) {
  const std::string other = kind == "chute" ? "discharge." : "chute.";
  for (const FieldRule& rule : scene_rules()) {
    std::string path(rule.path);
    if (path.rfind(other, 0) == 0) continue;
    if (path.rfind("chute.meshes", 0) == 0) continue;  // a job has triangles instead
    for (auto at = path.find("[]"); at != std::string::npos; at = path.find("[]")) {
      if (at + 2 == path.size()) break;  // lists of numbers have no column
      path.replace(at, 2, "[0]");
    }
    if (path.find("[]") != std::string::npos) continue;
    columns.push_back({path, "scene_field(j.id, " + quoted(path) + ")",
                       "scene field as run: " + std::string(rule.meaning)});
  }
}

ViewText values_view(const std::string& kind, const std::vector<ValueName>& values) {
  ViewText view{kind + "_values", "values, errors and scene fields of every " + kind + " job",
                "job j WHERE j.kind = " + quoted(kind), job_identity()};
  add_values(values, view.columns);
  view.columns.push_back({"cpu_s", cost("cpu_s"), "CPU time, filling included"});
  add_scene_fields(kind, view.columns);
  return view;
}

ViewText series_view() {
  return {"series",
          "values over time, at most 200 rows per name (all of them are in the result file)",
          "job_series s, series_rows(s.message) r",
          {{"job", job_text("s.job"), "name of the job"},
           {"name", "r.name", "remaining.remaining_percent, cg.x_m, flow.particle_count, ..."},
           {"time_s", "r.time_s", "simulated time"},
           {"value", "r.value", "unit in the name"}}};
}

ViewText studies_view() {
  return {"studies",
          "every study",
          "study s",
          {{"study", "'studies/' || s.id", "name of the study"},
           {"title", "nullif(s.name, '')", "as its owner called it"},
           {"kind", "s.kind", "sweep, optimize, price or ablate"},
           {"state",
            "CASE s.state WHEN 1 THEN 'running' WHEN 2 THEN 'paused' WHEN 3 THEN 'complete' WHEN 4 "
            "THEN 'cancelled' WHEN 5 THEN 'error' END",
            "running, paused, complete, cancelled or error"},
           {"owner", "s.owner", "who submitted it"},
           {"submitted", time_text("s.submitted_ms"), "UTC"},
           {"ended", time_text("s.ended_ms"), "UTC"},
           {"planned", "nullif(s.planned, 0)", "trials in all, if known"},
           {"trials", "s.trials", "proposed so far"},
           {"ended_trials", "s.told", "ended and taken into account"},
           {"failed_trials", "s.failed", "of these, without a result"},
           {"reused_trials", "s.reused", "answered from the store"},
           {"best_trial", "s.best_trial", "number"},
           {"best_objective", "s.best_objective", "mean of its runs"},
           {"best_objective_error", "s.best_objective_error", "half-width of the 95 % interval"},
           {"message", "nullif(s.message, '')", "why it is in this state"}}};
}

Columns trial_identity() {
  return {{"study", "'studies/' || t.study", "name of the study"},
          {"number", "t.number", "from 1"},
          {"job", job_text_or_null("t.job"), "NULL when the scene was refused"}};
}

// A trial's job is looked up: a join on the indexed expression of `jobs`.
std::string of_job(const std::string& expression) {
  return "(SELECT " + expression + " FROM job j WHERE j.id = t.job)";
}

std::string value_of_trial(const std::string& name) {
  return "(SELECT v.value FROM job_value v WHERE v.job = t.job AND v.name = " + quoted(name) + ")";
}

ViewText trials_view() {
  ViewText view{"trials", "every trial of every study", "trial t", trial_identity()};
  const Columns more = {
      {"state", "coalesce(" + of_job(kJobState) + ", 'error')", "of its job"},
      {"objective", "t.objective", "mean of its candidate's runs so far"},
      {"objective_error", "t.objective_error", "half-width of the 95 % interval"},
      {"feasible", "t.feasible", "1 when every constraint holds"},
      {"best_objective", "t.best_objective", "best feasible one up to this trial"},
      {"pareto", "t.pareto", "1 when no other trial is better in everything"},
      {"candidate", "t.candidate", "trials that differ only in the seed share it"},
      {"role", "t.role", "why it was proposed"},
      {"label", "t.label", "its inputs, short"},
      {"inputs", "t.inputs", "JSON object: scene path -> value"},
      {"error", "coalesce(nullif(t.error, ''), " + of_job("nullif(j.error, '')") + ")",
       "why it failed"}};
  view.columns.insert(view.columns.end(), more.begin(), more.end());
  return view;
}

ViewText pareto_view() {
  ViewText view{"pareto", "trials that no other trial of their study beats in everything",
                "trial t WHERE t.pareto = 1", trial_identity()};
  view.columns.push_back({"objective", "t.objective", "mean of its candidate's runs so far"});
  for (const char* name : {"f1_m", "f2_m", "f3_percent", "f4_m"})
    view.columns.push_back({name, value_of_trial(name), "value of its job"});
  view.columns.push_back({"inputs", "t.inputs", "JSON object: scene path -> value"});
  return view;
}

ViewText price_view() {
  return {"price",
          "what accuracy costs: the ladders of price studies",
          "price_point p",
          {{"study", "'studies/' || p.study", "name of the study"},
           {"job", job_text_or_null("p.job"), "name of the job"},
           {"rung", "p.rung", "the settings of this rung"},
           {"observable", "p.observable", "key of values"},
           {"value", "p.value", "what this rung gives"},
           {"error", "p.error", "estimated error"},
           {"cpu_s", "p.cpu_s", "its price"}}};
}

ViewText effects_view() {
  return {"effects",
          "what each effect contributes and costs: the pairs of ablation studies",
          "effect_delta e",
          {{"study", "'studies/' || e.study", "name of the study"},
           {"effect", "e.effect", "switched on and off"},
           {"observable", "e.observable", "key of values"},
           {"delta", "e.delta", "with minus without"},
           {"error", "e.error", "half-width of the 95 % interval"},
           {"cpu_ratio", "e.cpu_ratio", "cost with / cost without"}}};
}

ViewText tasks_view() {
  return {"tasks",
          "every execution of every job",
          "task t",
          {{"task", "'tasks/' || t.id", "name of the execution; its number is the fencing token"},
           {"job", job_text("t.job"), "name of the job"},
           {"worker", "t.worker", "where it ran"},
           {"started", time_text("t.started_ms"), "UTC"},
           {"ended", time_text("t.ended_ms"), "UTC"},
           {"outcome", "nullif(t.outcome, '')", "complete, error, unstable, worker lost, ..."},
           {"message", "nullif(t.message, '')", "what the worker said"}}};
}

ViewText workers_view() {
  return {"workers",
          "every worker that ever connected",
          "worker w",
          {{"worker", "w.id", "its name"},
           {"host", "w.host", "machine"},
           {"pid", "w.pid", "process"},
           {"slots", "w.slots", "jobs at a time"},
           {"state", "w.state", "connected, draining or lost"},
           {"engine_version", "w.engine_version", "part of every job key"},
           {"vector_path", "w.vector_path", "avx512, avx2 or portable"},
           {"first_seen", time_text("w.first_seen_ms"), "UTC"},
           {"state_since", time_text("w.seen_ms"), "UTC"}}};
}

}  // namespace

// The unit stays last: "mass_flow_kg_per_s" -> "mass_flow_error_kg_per_s".
std::string error_column(const ValueName& value) {
  static const std::map<std::string, std::string> suffixes = {
      {"m", "_m"},     {"%", "_percent"}, {"kg/s", "_kg_per_s"}, {"m/s", "_m_per_s"},
      {"deg", "_deg"}, {"s", "_s"},       {"kg", "_kg"},         {"rad/s", "_rad_per_s"}};
  const auto suffix = suffixes.find(value.unit);
  if (suffix == suffixes.end() || !value.name.ends_with(suffix->second))
    return value.name + "_error";
  return value.name.substr(0, value.name.size() - suffix->second.size()) + "_error" +
         suffix->second;
}

std::vector<ViewText> query_views(const KnownValues& seen) {
  return {jobs_view(),
          values_view("discharge", merged(documented_discharge_values(), seen.discharge)),
          values_view("chute", merged(documented_chute_values(), seen.chute)),
          series_view(),
          studies_view(),
          trials_view(),
          pareto_view(),
          price_view(),
          effects_view(),
          tasks_view(),
          workers_view()};
}

}  // namespace granary::server
