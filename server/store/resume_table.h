// Tables resume_file (what another worker needs to continue a job) and filling (settled fillings by
// key), and the list of artifacts that anything refers to.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <optional>
#include <string>
#include <vector>

#include "server/jobs/records.h"

namespace granary::server {

class ResumeTable {
 public:
  explicit ResumeTable(SQLite::Database& connection);

  void put_files(JobId job, const std::vector<ResumeFileRecord>& files);  // replaces
  std::vector<ResumeFileRecord> files(JobId job);
  void put_filling(const std::string& key, const StoredArtifact& artifact, std::int64_t now_ms);
  std::optional<StoredArtifact> find_filling(const std::string& key);
  std::vector<std::string> referenced();

 private:
  SQLite::Statement clear_files_, put_file_, files_, put_filling_, find_filling_, referenced_;
};

}  // namespace granary::server
