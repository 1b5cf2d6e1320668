// The SQL door: the documented views and nothing else, and no query that does not end.
#include "server/store/query_door.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "proto/contract/scene_text.h"
#include "server/jobs/new_job.h"
#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"
#include "server/store/study_table.h"

namespace granary::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Rows : public RowSink {
 public:
  void columns(const std::vector<std::string>& all) override { names = all; }
  bool row(std::vector<Cell> cells) override {
    rows.push_back(std::move(cells));
    return true;
  }
  std::vector<std::string> names;
  std::vector<std::vector<Cell>> rows;
};

class QueryDoor : public testing::Test {
 protected:
  QueryDoor() {
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(file.string() + suffix);
    database.emplace(file);
    store.emplace(database->connection());
    studies.emplace(database->connection());
  }

  JobId store_job(double rotation, double f1) {
    auto scene = parse_scene(
                     "discharge { particles { count: 20 diameter_min_m: 0.01 density_kg_per_m3: "
                     "2200 } bucket { shape: BEZIER x2_m: -0.1 x3_m: -0.2 x4_m: -0.3 } "
                     "friction_pp_deg: 30 friction_pw_deg: 20 "
                     "rotation_rad_per_s: 10 }",
                     "test")
                     ->scene;
    scene.mutable_discharge()->set_rotation_rad_per_s(rotation);
    NewJob job = new_job_of(scene).value();
    job.owner = "anna";
    job.tags = {{"batch", "7"}};
    const JobId id = store->insert_job(job, 1'700'000'000'000);
    JobRecord record = *store->find_job(id);
    record.state = v1::COMPLETE;
    store->update_job(record);
    v1::Result result;
    result.set_kind("discharge");
    v1::Quantity& value = (*result.mutable_values())["f1_m"];
    value.set_value(f1);
    value.set_error(0.25);
    value.set_unit("m");
    result.mutable_cost()->set_cpu_s(2 * rotation);
    store->put_result(id, result);
    return id;
  }

  Status ask(const std::string& sql, QueryLimits limits = {}) {
    rows = {};
    return run_query(file, sql, limits, rows, cancelled);
  }
  std::string text(std::size_t row, std::size_t column) {
    return std::get<std::string>(rows.rows.at(row).at(column));
  }
  double real(std::size_t row, std::size_t column) {
    return std::get<double>(rows.rows.at(row).at(column));
  }
  std::int64_t integer(std::size_t row, std::size_t column) {
    return std::get<std::int64_t>(rows.rows.at(row).at(column));
  }

  // Of its own: ctest runs several tests at a time.
  std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".db");
  std::optional<Database> database;
  std::optional<SqliteJobStore> store;
  std::optional<StudyTable> studies;
  std::atomic<bool> cancelled = false;
  Rows rows;
};

TEST_F(QueryDoor, gives_values_errors_costs_and_scene_fields_of_a_job) {
  store_job(8, 1.5);
  store_job(9, 1.75);
  const Status status =
      ask("SELECT job, state, f1_m, f1_error_m, cpu_s, \"discharge.rotation_rad_per_s\", "
          "\"discharge.bucket.shape\", \"discharge.particles.count\", f2_m FROM discharge_values "
          "ORDER BY f1_m DESC");
  ASSERT_TRUE(status.ok()) << status.error().message;
  ASSERT_EQ(rows.rows.size(), 2u);
  EXPECT_EQ(text(0, 0), "jobs/2");
  EXPECT_EQ(text(0, 1), "complete");
  EXPECT_EQ(real(0, 2), 1.75);
  EXPECT_EQ(real(0, 3), 0.25);
  EXPECT_EQ(real(0, 4), 18);
  EXPECT_EQ(real(0, 5), 9);
  EXPECT_EQ(text(0, 6), "BEZIER");
  EXPECT_EQ(integer(0, 7), 20);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(rows.rows[0][8]));
}

// The functions behind the columns go along with the scan: they must not care where it goes.
TEST_F(QueryDoor, gives_each_job_its_own_values_in_whatever_order_they_are_asked) {
  constexpr int kJobs = 60;
  for (int i = 1; i <= kJobs; ++i) {
    const JobId id = store_job(i, 0.5 * i);
    if (i % 3 == 0) store->delete_job(id);
  }
  // 17 is prime to 61: every number from 1 to 60 comes once, far from its neighbours.
  for (const char* order : {"i", "61 - i", "i * 17 % 61"}) {
    const std::string sql =
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 60), asked(i) AS "
        "MATERIALIZED "
        "(SELECT " +
        std::string(order) +
        " FROM n) "
        "SELECT asked.i, v.f1_m, v.f1_error_m, v.\"discharge.rotation_rad_per_s\" "
        "FROM asked LEFT JOIN discharge_values v ON v.job = 'jobs/' || asked.i";
    const Status status = ask(sql);
    ASSERT_TRUE(status.ok()) << status.error().message;
    ASSERT_EQ(rows.rows.size(), std::size_t{kJobs});
    for (std::size_t row = 0; row < rows.rows.size(); ++row) {
      const std::int64_t i = integer(row, 0);
      if (i % 3 == 0) {
        for (std::size_t column : {1, 2, 3})
          EXPECT_TRUE(std::holds_alternative<std::monostate>(rows.rows[row][column]))
              << order << ", job " << i;
        continue;
      }
      EXPECT_EQ(real(row, 1), 0.5 * static_cast<double>(i)) << order;
      EXPECT_EQ(real(row, 2), 0.25) << order;
      EXPECT_EQ(real(row, 3), static_cast<double>(i)) << order;
    }
  }
}

TEST_F(QueryDoor, knows_no_job_beyond_the_numbers_there_are) {
  store_job(8, 1.5);
  for (const char* job : {"0", "-1", "2", "9223372036854775807", "-9223372036854775807"}) {
    const std::string number = job;
    const Status status =
        ask("SELECT job_value(1, 'f1_m'), job_value(" + number + ", 'f1_m'), scene_field(" +
            number + ", 'seed'), job_value(1, 'f1_m')");
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(real(0, 0), 1.5);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(rows.rows[0][1])) << job;
    EXPECT_TRUE(std::holds_alternative<std::monostate>(rows.rows[0][2])) << job;
    EXPECT_EQ(real(0, 3), 1.5);
  }
}

// Found by fuzzing: SQLite quotes what it cannot read.
TEST_F(QueryDoor, a_refusal_is_one_line_whatever_the_statement_holds) {
  const Status status = ask("[\n\n\n");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message.find('\n'), std::string::npos) << status.error().message;
}

TEST_F(QueryDoor, every_view_of_the_contract_is_there_with_its_columns) {
  const std::vector<std::pair<std::string, std::string>> contract = {
      {"jobs", "job, kind, state, owner, tags, study, submitted"},
      {"discharge_values", "job, state, f1_m, f1_error_m, f3_percent, f3_error_percent, seed"},
      {"chute_values",
       "job, state, mass_flow_kg_per_s, mass_flow_error_kg_per_s, "
       "\"chute.particles[0].diameter_m\""},
      {"series", "job, name, time_s, value"},
      {"studies", "study, kind, state"},
      {"trials", "study, number, job, state, objective"},
      {"pareto", "study, number, job, f1_m, f4_m"},
      {"price", "study, job, rung, observable, value, error, cpu_s"},
      {"effects", "study, effect, observable, delta, error, cpu_ratio"},
      {"tasks", "job, worker, started, ended, outcome"},
      {"workers", "worker, host, slots, state"}};
  for (const auto& [view, columns] : contract) {
    const Status status = ask("SELECT " + columns + " FROM " + view);
    EXPECT_TRUE(status.ok()) << view << ": " << (status.ok() ? "" : status.error().message);
    EXPECT_TRUE(ask("SELECT * FROM " + view).ok()) << view;
  }
  EXPECT_EQ(list_views(file).size(), contract.size());
}

TEST_F(QueryDoor, values_that_no_list_names_get_columns_when_a_job_reports_them) {
  const JobId id = store_job(8, 1);
  EXPECT_FALSE(ask("SELECT bed_height_m FROM discharge_values").ok());
  v1::Result result;
  result.set_kind("discharge");
  (*result.mutable_values())["bed_height_m"].set_value(3);
  (*result.mutable_values())["bed_height_m"].set_unit("m");
  (*result.mutable_values())["x\"; DROP TABLE job"].set_value(3);  // no column, no harm
  store->put_result(id, result);
  ASSERT_TRUE(ask("SELECT bed_height_m, bed_height_error_m FROM discharge_values").ok());
  EXPECT_EQ(real(0, 0), 3);
}

TEST_F(QueryDoor, series_come_as_rows) {
  const JobId id = store_job(8, 1);
  v1::SeriesList list;
  v1::Series& series = *list.add_series();
  series.set_name("cg");
  for (const float time : {0.0f, 0.5f, 1.0f}) series.add_time_s(time);
  for (const char* name : {"x_m", "y_m"}) {
    v1::Series::Column& column = *series.add_columns();
    column.set_name(name);
    for (const float value : {1.0f, 2.0f, 4.0f}) column.add_values(value);
  }
  list.add_series()->set_name("empty");
  store->put_series(id, list);
  ASSERT_TRUE(ask("SELECT name, count(*), max(time_s), avg(value) FROM series WHERE job = 'jobs/1' "
                  "GROUP BY name ORDER BY name")
                  .ok());
  ASSERT_EQ(rows.rows.size(), 2u);
  EXPECT_EQ(text(0, 0), "cg.x_m");
  EXPECT_EQ(integer(0, 1), 3);
  EXPECT_EQ(real(1, 2), 1);
  EXPECT_NEAR(real(1, 3), 7.0 / 3, 1e-12);
}

TEST_F(QueryDoor, joins_trials_with_values_by_the_job_s_name) {
  store_job(8, 1);
  StudyRecord study;
  study.kind = "sweep";
  study.id = studies->insert_study(study);
  TrialRecord trial;
  trial.study = study.id;
  trial.number = 1;
  trial.job = 1;
  trial.inputs = R"({"seed":"1"})";
  studies->insert_trial(trial);
  const Status status = ask(
      "SELECT t.study, t.number, t.state, d.f1_m, json_extract(t.inputs, '$.seed') FROM trials t "
      "JOIN discharge_values d ON d.job = t.job");
  ASSERT_TRUE(status.ok()) << status.error().message;
  ASSERT_EQ(rows.rows.size(), 1u);
  EXPECT_EQ(text(0, 0), "studies/1");
  EXPECT_EQ(text(0, 2), "complete");
  EXPECT_EQ(real(0, 3), 1);
}

struct Refusal {
  const char* sql;
  ErrorCode code;
};

TEST_F(QueryDoor, refuses_everything_but_one_select_over_the_views) {
  store_job(8, 1);
  const auto denied = ErrorCode::permission_denied;
  const auto wrong = ErrorCode::invalid_argument;
  const std::vector<Refusal> refusals = {
      {"INSERT INTO job_tag VALUES (1, 'a', 'b')", denied},
      {"UPDATE job SET owner = 'me'", denied},
      {"DELETE FROM job", denied},
      {"DELETE FROM jobs", denied},
      {"DROP TABLE job", denied},
      {"CREATE TABLE t (x)", denied},
      {"CREATE TEMP TABLE t (x)", denied},
      {"CREATE TEMP VIEW t AS SELECT 1", denied},
      {"ALTER TABLE job RENAME TO j", denied},
      {"ATTACH '/tmp/x.db' AS x", denied},
      {"DETACH main", denied},
      {"PRAGMA journal_mode = DELETE", denied},
      {"PRAGMA user_version", denied},
      {"PRAGMA query_only = OFF", denied},
      {"SELECT * FROM pragma_database_list", denied},
      {"SELECT * FROM pragma_table_info('job')", denied},
      {"VACUUM", denied},
      {"VACUUM INTO '/tmp/copy.db'", denied},
      {"BEGIN", denied},
      {"SAVEPOINT x", denied},
      {"REINDEX", denied},
      {"ANALYZE", denied},
      {"EXPLAIN SELECT * FROM jobs", denied},
      {"EXPLAIN QUERY PLAN SELECT * FROM jobs", denied},
      {"SELECT * FROM job", denied},
      {"SELECT scene FROM main.job", denied},
      {"SELECT * FROM request", denied},
      {"SELECT * FROM sqlite_schema", denied},
      {"SELECT * FROM sqlite_temp_schema", denied},
      {"SELECT * FROM sqlite_master", denied},
      {"SELECT * FROM dbstat", denied},
      {"SELECT (SELECT count(*) FROM request)", denied},
      {"SELECT 1 FROM job_tag", denied},
      {"SELECT (SELECT max(id) FROM job)", denied},
      {"SELECT * FROM jobs WHERE job IN (SELECT worker FROM task)", denied},
      // A subquery that calls itself like one of the views.
      {"WITH jobs AS (SELECT scene FROM job) SELECT * FROM jobs", denied},
      {"SELECT * FROM (SELECT scene FROM job) AS jobs", denied},
      {"WITH trials(x) AS (SELECT id FROM main.request) SELECT * FROM trials", denied},
      {"SELECT load_extension('/tmp/x.so')", denied},
      {"SELECT 1; SELECT 2", wrong},
      {"SELECT 1; DROP TABLE job", wrong},
      {"SELECT", wrong},
      {"", wrong},
      {"-- nothing", wrong},
      {"SELECT f1 FROM discharge_values", wrong},
      {"SELECT \"no such column\" FROM jobs", wrong},
      {"SELECT * FROM nowhere", wrong},
      {"SELECT unknown_function(1)", wrong},
  };
  for (const Refusal& refusal : refusals) {
    const Status status = ask(refusal.sql);
    ASSERT_FALSE(status.ok()) << refusal.sql;
    EXPECT_EQ(status.error().code, refusal.code) << refusal.sql << ": " << status.error().message;
    EXPECT_TRUE(rows.rows.empty()) << refusal.sql;
  }
  EXPECT_EQ(store->find_job(1)->owner, "anna");
}

TEST_F(QueryDoor, a_comment_or_semicolon_behind_the_statement_is_no_second_one) {
  EXPECT_TRUE(ask("SELECT 1;").ok());
  EXPECT_TRUE(ask("SELECT 1 -- done").ok());
  EXPECT_TRUE(ask("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 10) "
                  "SELECT sum(i) FROM n;  ")
                  .ok());
  EXPECT_EQ(integer(0, 0), 55);
}

TEST_F(QueryDoor, stops_what_does_not_end_in_time) {
  for (int i = 1; i <= 20; ++i) store_job(i, 1);
  const std::string numbers =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT 10000) ";
  for (const std::string& sql :
       {std::string(
            "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT max(i) FROM n"),
        numbers + "SELECT count(*) FROM n a, n b",
        std::string(
            "SELECT count(*) FROM jobs a, jobs b, jobs c, jobs d, jobs e, jobs f, jobs g")}) {
    const auto start = std::chrono::steady_clock::now();
    const Status status = ask(sql, {0.2, 1000});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    ASSERT_FALSE(status.ok()) << sql;
    EXPECT_EQ(status.error().code, ErrorCode::deadline_exceeded) << sql;
    EXPECT_LT(took.count(), 2.0) << sql;
  }
}

TEST_F(QueryDoor, limits_rows_and_memory) {
  const std::string endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) ";
  Status status = ask(endless + "SELECT i FROM n", {10, 100});
  EXPECT_EQ(status.error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(rows.rows.size(), 100u);
  status = ask(endless +
                   "SELECT sum(length(x)) FROM (SELECT zeroblob(1000000) || i AS x FROM n "
                   "ORDER BY x)",
               {30, 100});
  EXPECT_EQ(status.error().code, ErrorCode::resource_exhausted) << status.error().message;
  EXPECT_EQ(ask("SELECT zeroblob(1000000000)").error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(ask("SELECT 1, 2, 3", {10, 1}).ok(), true);
}

TEST_F(QueryDoor, stops_when_the_caller_leaves) {
  cancelled = true;
  const Status status =
      ask("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n");
  EXPECT_EQ(status.error().code, ErrorCode::cancelled);
}

TEST_F(QueryDoor, reads_beside_a_writer_and_sees_what_is_committed) {
  database->begin();
  store_job(8, 1);
  const Status meanwhile = ask("SELECT count(*) FROM jobs");
  ASSERT_TRUE(meanwhile.ok()) << meanwhile.error().message;
  EXPECT_EQ(integer(0, 0), 0);
  database->commit();
  ASSERT_TRUE(ask("SELECT count(*) FROM jobs").ok());
  EXPECT_EQ(integer(0, 0), 1);
}

}  // namespace
}  // namespace granary::server
