// Which run a file belongs to. A checkpoint or segment is only ever used by a run with the same
// three strings, because only such a run continues bitwise.
#pragma once

#include <cstdint>
#include <string>

namespace granary::storage {

struct RunIdentity {
  std::string scene_key;       // hash of the resolved scene, whatever decides stored bytes included
  std::string engine_version;  // of the code that computes
  std::string vector_path;     // "avx512", "avx2", "portable": not bitwise the same as each other

  bool operator==(const RunIdentity&) const = default;
  std::string text() const { return scene_key + '\n' + engine_version + '\n' + vector_path; }
};

}  // namespace granary::storage
