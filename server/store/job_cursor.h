// A statement over rows in the order of their jobs that goes along with whoever asks for jobs in
// about that order, instead of being looked up from the root of its tree for each.
#pragma once

#include <sqlite3.h>

#include <limits>
#include <string>

namespace granary::server {

class JobCursor {
 public:
  // Column 0 of `sql` is the job; its rows have job >= ?1 and come in that order, one a job at
  // most; `name` is ?2, if not empty. Ends with its connection at the latest.
  JobCursor(sqlite3* connection, const char* sql, const std::string& name = "") {
    status_ =
        sqlite3_prepare_v3(connection, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement_, nullptr);
    if (status_ == SQLITE_OK && !name.empty())
      status_ = sqlite3_bind_text(statement_, 2, name.c_str(), -1, SQLITE_TRANSIENT);
  }
  ~JobCursor() { sqlite3_finalize(statement_); }
  JobCursor(const JobCursor&) = delete;
  JobCursor& operator=(const JobCursor&) = delete;

  // SQLITE_ROW: row() is that of the job; SQLITE_DONE: it has none; otherwise SQLite's error.
  int move_to(sqlite3_int64 job) {
    if (statement_ == nullptr) return status_;
    if (job < 1) return SQLITE_DONE;  // their numbers start at 1
    if (job <= before_ || (job > at_ && job - at_ > kFarthestWalk)) {
      sqlite3_reset(statement_);
      sqlite3_bind_int64(statement_, 1, job);
      at_ = job - 1;
      step();
    }
    while (at_ < job && status_ == SQLITE_ROW) step();
    if (status_ != SQLITE_ROW && status_ != SQLITE_DONE) return forget();
    return at_ == job ? SQLITE_ROW : SQLITE_DONE;
  }
  sqlite3_stmt* row() const { return statement_; }

 private:
  static constexpr sqlite3_int64 kNowhere = std::numeric_limits<sqlite3_int64>::max();
  static constexpr sqlite3_int64 kFarthestWalk = 16;  // rows; a fresh look-up costs about as much

  void step() {
    before_ = at_;
    status_ = sqlite3_step(statement_);
    at_ = status_ == SQLITE_ROW ? sqlite3_column_int64(statement_, 0) : kNowhere;
  }
  int forget() {
    before_ = at_ = kNowhere;
    return status_;
  }

  sqlite3_stmt* statement_ = nullptr;
  int status_ = SQLITE_OK;
  sqlite3_int64 before_ = kNowhere, at_ = kNowhere;  // no row lies between these two jobs
};

}  // namespace granary::server
