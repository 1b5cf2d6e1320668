// Reads a result file as a user would: plain HDF5, no code of worker/storage.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace granary::testing {

struct StoredDataset {
  std::string units;  // "" when there is no such attribute
  std::vector<std::byte> bytes;
  std::vector<unsigned long long> extents;  // empty: scalar
  bool has_data = true;                     // false: null dataspace

  template <typename T>
  std::vector<T> as() const {
    const T* first = reinterpret_cast<const T*>(bytes.data());
    return {first, first + bytes.size() / sizeof(T)};
  }
  std::string text() const;  // padding cut off
};

struct StoredResult {
  std::map<std::string, StoredDataset> datasets;  // by every path that leads to one
  std::map<std::string, std::string> texts;       // "path@attribute"
  std::map<std::string, double> numbers;          // "path@attribute"

  std::map<std::string, StoredDataset> below(const std::string& prefix) const;
};

// Throws std::runtime_error when the library cannot open it.
StoredResult read_result(const std::filesystem::path& path);

bool operator==(const StoredDataset& a, const StoredDataset& b);

}  // namespace granary::testing
