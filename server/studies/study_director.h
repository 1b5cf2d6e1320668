// Leads studies through their life: hears that jobs of theirs have ended, tells their generators in
// trial order, asks for more and submits it as ordinary jobs. Runs on the owner thread inside its
// transactions: what a generator was told, its state after it, and the jobs it proposed then are
// committed together or not at all. After a crash the same state asks for the same next trials.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/jobs/dispatcher.h"
#include "server/studies/study_store.h"

namespace granary::server {

class StudyWatcher {
 public:
  virtual ~StudyWatcher() = default;
  virtual void deliver(const v1::Study& study) = 0;  // must not block
  virtual void finish() = 0;
};

struct NewStudy {
  v1::StudySpec spec;
  std::string owner;
  std::string request_id;
};

v1::Study to_message(const StudyRecord& study);

class StudyDirector {
 public:
  using MakeGenerator =
      std::function<Result<std::unique_ptr<StudyGenerator>>(const v1::StudySpec&)>;

  StudyDirector(StudyStore& store, JobStore& jobs, Dispatcher& dispatcher,
                MakeGenerator make = make_generator);

  // Forgets all memory and takes up every running study where the database has it.
  void reload();

  Result<StudyRecord> submit(const NewStudy& study, Now now);
  Result<StudyRecord> find(StudyId id);
  Result<StudyRecord> pause(StudyId id, Now now);
  Result<StudyRecord> resume(StudyId id, Now now);
  Result<StudyRecord> extend(StudyId id, std::uint32_t budget, Now now);
  Result<StudyRecord> cancel(StudyId id, bool keep_jobs, Now now);

  Status watch(StudyId id, std::shared_ptr<StudyWatcher> watcher);
  void unwatch(StudyId id, const StudyWatcher* watcher);

  // Advances what has news, a bounded piece; call before each commit. has_work(): call again.
  void work(Now now);
  bool has_work() const { return !to_advance_.empty(); }
  bool idle() const { return watchers_.empty(); }
  std::size_t running() const { return live_.size(); }  // or paused

  std::vector<std::function<void()>> take_effects() { return std::exchange(effects_, {}); }

 private:
  struct Live {
    StudyRecord record;
    v1::StudySpec spec;
    std::unique_ptr<StudyGenerator> generator;
  };

  Live* load(StudyId id);
  Result<Live*> live_of(StudyId id, const char* what);
  void advance(Live& live, Now now);
  bool tell_next(Live& live);
  bool propose(Live& live, std::size_t limit, Now now);
  void submit_trial(Live& live, TrialProposal proposal, Now now);
  Result<JobId> queue(const Live& live, const v1::Scene& scene, Now now);
  std::optional<TrialOutcome> outcome_of(const TrialRecord& trial);
  void fail(Live& live, const std::string& why, Now now);
  void end_if_done(Live& live, Now now);
  void save(Live& live);
  void publish(const StudyRecord& record);
  void cancel_jobs(const StudyRecord& record, Now now);

  StudyStore& store_;
  JobStore& jobs_;
  Dispatcher& dispatcher_;
  MakeGenerator make_;
  std::map<StudyId, Live> live_;
  std::set<StudyId> to_advance_;
  std::map<StudyId, std::vector<std::shared_ptr<StudyWatcher>>> watchers_;
  std::vector<std::function<void()>> effects_;
};

}  // namespace granary::server
