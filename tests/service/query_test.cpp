// The query verb against a real server.
#include <gmock/gmock.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Query : public RealService {};

TEST_F(Query, answers_in_three_formats) {
  submit({scene("discharge_small"), "--tag", "a=b"});
  const std::string sql = "SELECT job, state, json_extract(tags, '$.a') AS a FROM jobs";
  const Outputs as_json = granary({"query", sql, "--format", "json"});
  EXPECT_EQ(as_json.out, "[{\"job\":\"jobs/1\",\"state\":\"waiting\",\"a\":\"b\"}]\n")
      << as_json.err;
  EXPECT_EQ(granary({"query", sql, "--format", "csv"}).out, "job,state,a\njobs/1,waiting,b\n");
  EXPECT_THAT(granary({"query", sql}).out, HasSubstr("jobs/1  waiting  b"));
  EXPECT_EQ(granary({"query", "-", "--format", "csv"}, "SELECT 1 AS one").out, "one\n1\n");
  EXPECT_EQ(granary({"query", "SELECT job FROM jobs WHERE 0", "--format", "json"}).out, "[]\n");
}

TEST_F(Query, shows_its_schema) {
  const Outputs outputs = granary({"query", "--schema", "--format", "json"});
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  std::set<std::string> columns;
  for (const json& row : json::parse(outputs.out))
    columns.insert(row["view"].get<std::string>() + "." + row["column"].get<std::string>());
  for (const char* column :
       {"jobs.job", "discharge_values.f1_error_m", "series.time_s", "price.rung",
        "discharge_values.discharge.rotation_rad_per_s", "tasks.outcome"})
    EXPECT_EQ(columns.count(column), 1u) << column;
}

TEST_F(Query, refusals_have_the_exit_codes_of_the_contract) {
  EXPECT_EQ(granary({"query", "DELETE FROM jobs"}).exit_code, 5);
  EXPECT_EQ(granary({"query", "ATTACH 'x' AS y"}).exit_code, 5);
  EXPECT_EQ(granary({"query", "SELECT nonsense"}).exit_code, 2);
  EXPECT_EQ(granary({"query"}).exit_code, 2);
  const std::string endless =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n";
  EXPECT_EQ(granary({"query", endless, "--time-limit", "0.3s"}).exit_code, 8);
  const Outputs many =
      granary({"query",
               "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT "
               "5000) SELECT i FROM n",
               "--limit", "4999"});
  EXPECT_EQ(many.exit_code, 1);
  EXPECT_EQ(many.out, "");
  EXPECT_THAT(many.err, HasSubstr("4999"));
}

TEST_F(Query, thousands_of_rows_are_streamed_whole) {
  const Outputs outputs =
      granary({"query",
               "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT "
               "50000) SELECT i, 'row ' || i FROM n",
               "--format", "csv"});
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(std::count(outputs.out.begin(), outputs.out.end(), '\n'), 50'001);
  EXPECT_THAT(outputs.out, HasSubstr("\n50000,row 50000\n"));
}

TEST_F(Query, series_tasks_and_workers_of_a_finished_job_are_there) {
  start_worker();
  submit({scene("discharge_small"), "--set", "discharge.particles.count=60", "--wait"});
  const auto one = [&](const std::string& sql) {
    const Outputs outputs = granary({"query", sql, "--format", "json"});
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    return json::parse(outputs.out)[0];
  };
  const json series =
      one("SELECT count(*) AS n, max(value) AS most FROM series WHERE job = 'jobs/1' AND name = "
          "'remaining.remaining_percent'");
  EXPECT_GT(series["n"], 50);
  EXPECT_EQ(series["most"], 100.0);
  EXPECT_EQ(one("SELECT outcome FROM tasks WHERE job = 'jobs/1'")["outcome"], "complete");
  EXPECT_EQ(one("SELECT state FROM workers")["state"], "connected");
  EXPECT_GT(one("SELECT cpu_s FROM jobs")["cpu_s"], 0.0);
}

}  // namespace
}  // namespace granary::test
