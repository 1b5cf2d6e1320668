// A prepared statement for the length of one use: a statement left un-reset keeps its read
// transaction open, so it is reset on every way out.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

namespace granary::server {

class Use {
 public:
  explicit Use(SQLite::Statement& statement) : statement_(statement) {
    statement_.reset();
    statement_.clearBindings();
  }
  ~Use() { statement_.tryReset(); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

  SQLite::Statement* operator->() { return &statement_; }

 private:
  SQLite::Statement& statement_;
};

}  // namespace granary::server
