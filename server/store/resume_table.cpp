#include "server/store/resume_table.h"

#include "server/store/statement_use.h"

namespace granary::server {

ResumeTable::ResumeTable(SQLite::Database& c)
    : clear_files_(c, "DELETE FROM resume_file WHERE job = ?"),
      put_file_(c, "INSERT INTO resume_file (job, name, sha256, size_bytes) VALUES (?, ?, ?, ?)"),
      files_(c, "SELECT name, sha256, size_bytes FROM resume_file WHERE job = ?"),
      put_filling_(c,
                   "INSERT OR REPLACE INTO filling (key, sha256, size_bytes, created_ms) "
                   "VALUES (?, ?, ?, ?)"),
      find_filling_(c, "SELECT sha256, size_bytes FROM filling WHERE key = ?"),
      referenced_(c,
                  "SELECT result_sha256 FROM job WHERE result_sha256 <> '' UNION "
                  "SELECT sha256 FROM resume_file UNION SELECT sha256 FROM filling") {}

void ResumeTable::put_files(JobId job, const std::vector<ResumeFileRecord>& files) {
  {
    Use clear(clear_files_);
    clear->bind(1, job);
    clear->exec();
  }
  for (const ResumeFileRecord& file : files) {
    Use row(put_file_);
    row->bind(1, job);
    row->bind(2, file.name);
    row->bind(3, file.artifact.sha256);
    row->bind(4, static_cast<std::int64_t>(file.artifact.size_bytes));
    row->exec();
  }
}

std::vector<ResumeFileRecord> ResumeTable::files(JobId job) {
  Use row(files_);
  row->bind(1, job);
  std::vector<ResumeFileRecord> files;
  while (row->executeStep())
    files.push_back({row->getColumn(0).getString(),
                     {row->getColumn(1).getString(),
                      static_cast<std::uint64_t>(row->getColumn(2).getInt64())}});
  return files;
}

void ResumeTable::put_filling(const std::string& key, const StoredArtifact& artifact,
                              std::int64_t now_ms) {
  Use row(put_filling_);
  row->bind(1, key);
  row->bind(2, artifact.sha256);
  row->bind(3, static_cast<std::int64_t>(artifact.size_bytes));
  row->bind(4, now_ms);
  row->exec();
}

std::optional<StoredArtifact> ResumeTable::find_filling(const std::string& key) {
  Use row(find_filling_);
  row->bind(1, key);
  if (!row->executeStep()) return {};
  return StoredArtifact{row->getColumn(0).getString(),
                        static_cast<std::uint64_t>(row->getColumn(1).getInt64())};
}

std::vector<std::string> ResumeTable::referenced() {
  Use row(referenced_);
  std::vector<std::string> out;
  while (row->executeStep()) out.push_back(row->getColumn(0).getString());
  return out;
}

}  // namespace granary::server
