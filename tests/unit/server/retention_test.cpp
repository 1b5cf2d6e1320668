// What leaves after --keep-days and what stays.
#include "server/jobs/retention.h"

#include <gtest/gtest.h>

#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"

namespace granary::server {
namespace {

constexpr std::int64_t kDayMs = 86'400'000, kStart = 1'700'000'000'000;

class RetentionTest : public testing::Test {
 protected:
  JobId job(v1::JobState state, std::int64_t ended_ms, std::map<std::string, std::string> tags = {},
            StudyId study = 0) {
    NewJob job;
    job.kind = "discharge";
    job.tags = std::move(tags);
    job.study = study;
    const JobId id = store.insert_job(job, kStart);
    JobRecord record = *store.find_job(id);
    record.state = state;
    record.ended_ms = ended_ms;
    record.result_sha256 = "file of " + job_name(id);
    store.update_job(record);
    return id;
  }
  StudyId study(std::int64_t ended_ms) {
    database.connection().exec(
        "INSERT INTO study (kind, name, state, owner, request_id, spec, generator, submitted_ms, "
        "ended_ms) "
        "VALUES ('sweep', '', 1, '', '', x'', x'', 1, " +
        std::to_string(ended_ms) + ")");
    return database.connection().getLastInsertRowid();
  }
  // Until a pass has ended.
  std::size_t work_at(std::int64_t wall_ms) {
    std::size_t removed = 0;
    for (int call = 0; call < 10; ++call) removed += retention.work({wall_ms, steady_ms});
    steady_ms += kDayMs;
    return removed;
  }
  bool there(JobId id) { return store.find_job(id).has_value(); }

  Database database{":memory:"};
  SqliteJobStore store{database.connection()};
  Dispatcher dispatcher{store, {}};
  Retention retention{store, dispatcher, 30};
  std::int64_t steady_ms = 1000;
};

TEST_F(RetentionTest, removes_what_ended_before_and_keeps_the_rest) {
  const JobId old = job(v1::COMPLETE, kStart + kDayMs), failed = job(v1::ERROR, kStart + kDayMs),
              recent = job(v1::COMPLETE, kStart + 20 * kDayMs), running = job(v1::RUNNING, 0),
              waiting = job(v1::WAITING, 0), kept = job(v1::COMPLETE, kStart, {{"keep", ""}});
  EXPECT_EQ(work_at(kStart + 30 * kDayMs), 0u);
  EXPECT_EQ(work_at(kStart + 40 * kDayMs), 2u);
  EXPECT_FALSE(there(old));
  EXPECT_FALSE(there(failed));
  for (const JobId id : {recent, running, waiting, kept}) EXPECT_TRUE(there(id)) << id;
  const std::vector<std::string> files = store.referenced_artifacts();
  EXPECT_EQ(std::count(files.begin(), files.end(), "file of " + job_name(old)), 0)
      << "the sweep may take its file";
}

TEST_F(RetentionTest, keeps_the_jobs_of_a_study_until_it_has_ended) {
  const JobId of_running = job(v1::COMPLETE, kStart, {}, study(0)),
              of_ended = job(v1::COMPLETE, kStart, {}, study(5));
  EXPECT_EQ(work_at(kStart + 40 * kDayMs), 1u);
  EXPECT_TRUE(there(of_running));
  EXPECT_FALSE(there(of_ended));
}

TEST_F(RetentionTest, goes_through_any_number_of_jobs_in_pieces) {
  std::vector<JobId> ids;
  for (int k = 0; k < 1200; ++k) ids.push_back(job(v1::COMPLETE, kStart));
  const Now late{kStart + 40 * kDayMs, 1000};
  EXPECT_EQ(retention.work(late), 500u);
  EXPECT_EQ(retention.work(late), 500u);
  EXPECT_EQ(retention.work(late), 200u);
  EXPECT_EQ(retention.work(late), 0u) << "rests until the next pass";
  for (const JobId id : ids) EXPECT_FALSE(there(id));
}

TEST_F(RetentionTest, forgets_fillings_that_no_open_job_asks_for) {
  store.put_filling("unused", {"a", 1}, kStart);
  store.put_filling("asked for", {"b", 1}, kStart);
  store.put_filling("recent", {"c", 1}, kStart + 35 * kDayMs);
  NewJob open;
  open.kind = "discharge";
  open.filling_key = "asked for";
  store.insert_job(open, kStart + 39 * kDayMs);
  work_at(kStart + 40 * kDayMs);
  EXPECT_FALSE(store.find_filling("unused"));
  EXPECT_TRUE(store.find_filling("asked for"));
  EXPECT_TRUE(store.find_filling("recent"));
}

TEST_F(RetentionTest, without_a_limit_nothing_leaves) {
  Retention forever(store, dispatcher, 0);
  job(v1::COMPLETE, kStart);
  EXPECT_EQ(forever.work({kStart + 4000 * kDayMs, 1000}), 0u);
}

}  // namespace
}  // namespace granary::server
