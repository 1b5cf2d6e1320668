// Writes one result file: everything goes to `<path>.tmp`, and only a complete, closed and synced
// file gets its name. The layout is a public format: worker/storage/README.md.
#pragma once

#include <memory>

#include "worker/storage/file_system.h"
#include "worker/storage/result_content.h"
#include "worker/storage/segment.h"

namespace granary::storage {

constexpr int kResultFormatVersion = 1;

class ResultWriter {
 public:
  ResultWriter(FileSystem& files, Path path);
  ~ResultWriter();  // removes the temporary file when commit() was not reached
  ResultWriter(const ResultWriter&) = delete;
  ResultWriter& operator=(const ResultWriter&) = delete;

  void add_frame(const Frame& frame);
  void add_content(const ResultContent& content);
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace granary::storage
