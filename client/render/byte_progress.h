// How much of a file has arrived: one line on stderr, redrawn in place; nothing when it is not shown.
#pragma once

#include <cstdint>

namespace granary::render {

class ByteProgress {
 public:
  explicit ByteProgress(bool shown) : shown_(shown) {}
  void show(std::uint64_t have_bytes, std::uint64_t size_bytes);
  void close() const;

 private:
  bool shown_;
  int percent_ = -1;
};

}  // namespace granary::render
