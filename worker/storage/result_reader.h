// Reads a result file for the exports: tables of /series and /fields, frames, the kind of scene.
// Numbers arrive as doubles, whatever they are stored as. Every failure is a StorageError.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/storage/file_system.h"

namespace granary::storage {

struct NumberColumn {
  std::string name;
  std::size_t width = 1;  // 2 for plane vectors, 3 for space vectors
  std::vector<double> values;  // rows x width

  std::size_t rows() const { return values.size() / width; }
};

struct NumberTable {
  std::string name;
  std::vector<NumberColumn> columns;

  const NumberColumn* find(std::string_view column) const;
  const NumberColumn& required(std::string_view column) const;  // else the file is damaged
};

// Damaged when columns of the table `name` differ in length.
void check_lengths(const std::string& name, std::span<const NumberColumn> columns);

struct StoredFrame {
  double time_s = 0;
  std::string phase;
  NumberTable grains;
};

class ResultReader {
 public:
  explicit ResultReader(const Path& result);
  ~ResultReader();
  ResultReader(const ResultReader&) = delete;
  ResultReader& operator=(const ResultReader&) = delete;

  std::string kind() const;
  std::vector<std::string> table_names(std::string_view group) const;  // "series" or "fields"
  NumberTable table(std::string_view group, const std::string& name) const;
  std::size_t frame_count() const;
  StoredFrame frame(std::size_t index) const;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace granary::storage
