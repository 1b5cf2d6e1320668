// A directory that is gone when the test is. In memory where there is such a place: tests of
// durability sync thousands of times, and what they check is the order of operations, not the disk.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace granary::testing {

class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (parent() / "granary-test-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary directory");
    path_ = pattern;
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  static std::filesystem::path parent() {
    const std::filesystem::path memory = "/dev/shm";
    const bool chosen = std::getenv("TMPDIR") != nullptr;
    return !chosen && access(memory.c_str(), W_OK) == 0 ? memory
                                                        : std::filesystem::temp_directory_path();
  }
  std::filesystem::path path_;
};

}  // namespace granary::testing
