#include "worker/storage/verify.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "worker/storage/hdf5_file_writer.h"
#include "worker/storage/result_writer.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using hdf5::check;
using hdf5::Handle;

constexpr std::size_t kMaxProblems = 100;  // a file full of damage needs no longer list

struct DatasetContent {
  std::string unit;
  H5T_class_t type_class = H5T_NO_CLASS;
  std::size_t element_bytes = 0;
  std::vector<std::byte> bytes;
};

std::string read_text_attribute(hid_t object, const char* name, const std::string& path) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose,
                         "find attribute " + std::string(name) + " of " + path);
  const Handle type(H5Aget_type(attribute), H5Tclose, "read attribute of " + path);
  if (H5Tis_variable_str(type) <= 0)
    throw StorageError(StorageFault::damaged, path + ": " + name + " is no text");
  char* text = nullptr;
  check(H5Aread(attribute, type, &text), "read attribute of " + path);
  std::string value = text == nullptr ? "" : text;
  H5free_memory(text);
  return value;
}

DatasetContent read_dataset(hid_t file, const std::string& path) {
  const Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "open " + path);
  const Handle type(H5Dget_type(dataset), H5Tclose, "read type of " + path);
  const Handle space(H5Dget_space(dataset), H5Sclose, "read shape of " + path);
  DatasetContent content;
  if (H5Aexists(dataset, "units") > 0) content.unit = read_text_attribute(dataset, "units", path);
  content.type_class = H5Tget_class(type);
  content.element_bytes = H5Tget_size(type);
  const hssize_t element_count = H5Sget_simple_extent_npoints(space);
  content.bytes.resize(static_cast<std::size_t>(element_count) * content.element_bytes);
  if (!content.bytes.empty())
    check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, content.bytes.data()),
          "read " + path);
  return content;
}

template <typename T>
bool all_finite(std::span<const std::byte> bytes) {
  const std::span values(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T));
  return std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); });
}

bool is_finite(const DatasetContent& content) {
  if (content.type_class != H5T_FLOAT) return true;
  return content.element_bytes == sizeof(float) ? all_finite<float>(content.bytes)
                                                : all_finite<double>(content.bytes);
}

// Series and fields may hold NaN: "no data in this cell or at this time".
bool must_be_finite(const std::string& path) {
  for (const char* prefix : {"/values/", "/replicates/", "/ledger/", "/frames/"})
    if (path.starts_with(prefix)) return true;
  return false;
}

std::map<std::string, std::uint64_t> read_checksums(hid_t file) {
  const DatasetContent paths = read_dataset(file, "/checksums/path");
  const DatasetContent sums = read_dataset(file, "/checksums/xxh3");
  std::map<std::string, std::uint64_t> checksums;
  const std::size_t count = sums.bytes.size() / sizeof(std::uint64_t);
  if (count * paths.element_bytes != paths.bytes.size())
    throw StorageError(StorageFault::damaged, "/checksums: columns of different length");
  const auto* text = reinterpret_cast<const char*>(paths.bytes.data());
  for (std::size_t i = 0; i < count; ++i) {
    const char* start = text + i * paths.element_bytes;
    const std::string path(start, strnlen(start, paths.element_bytes));
    std::memcpy(&checksums[path], sums.bytes.data() + i * sizeof(std::uint64_t),
                sizeof(std::uint64_t));
  }
  return checksums;
}

class Verifier {
 public:
  explicit Verifier(const Path& path)
      : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose,
              "open " + path.string()) {}

  VerifyReport run() {
    check_format();
    expected_ = read_checksums(file_);
    check(H5Ovisit2(file_, H5_INDEX_NAME, H5_ITER_INC, &Verifier::visit, this, H5O_INFO_BASIC),
          "walk through the file");
    for (const auto& [path, checksum] : expected_)
      if (!seen_.contains(path)) add_problem(path + ": is missing");
    return report_;
  }

 private:
  void add_problem(std::string problem) {
    if (report_.problems.size() < kMaxProblems) report_.problems.push_back(std::move(problem));
  }

  void check_format() {
    if (read_text_attribute(file_, "format", "/") != "granary-result")
      throw StorageError(StorageFault::damaged, "not a Granary result file");
    const Handle attribute(H5Aopen(file_, "format_version", H5P_DEFAULT), H5Aclose,
                           "find the format version");
    std::uint64_t version = 0;
    check(H5Aread(attribute, H5T_NATIVE_UINT64, &version), "read the format version");
    if (version != kResultFormatVersion)
      add_problem("format version " + std::to_string(version) + " is not known here");
  }

  // Called by the library for every object, each once even when it has several links.
  static herr_t visit(hid_t, const char* name, const H5O_info_t* info, void* self) {
    auto* verifier = static_cast<Verifier*>(self);
    const std::string path = "/" + std::string(name);
    try {
      if (info->type == H5O_TYPE_DATASET) verifier->check_dataset(path);
      if (info->type == H5O_TYPE_GROUP && verifier->is_frame(path)) ++verifier->report_.frame_count;
    } catch (const StorageError& error) {
      verifier->add_problem(path + ": " + error.what());
    }
    return 0;
  }

  static bool is_frame(const std::string& path) {
    constexpr std::string_view kFrames = "/frames/";
    return path.starts_with(kFrames) && path.find('/', kFrames.size()) == std::string::npos;
  }

  void check_dataset(const std::string& path) {
    const DatasetContent content = read_dataset(file_, path);
    ++report_.dataset_count;
    report_.data_bytes += content.bytes.size();
    if (content.unit.empty()) add_problem(path + ": has no units");
    if (must_be_finite(path) && !is_finite(content)) add_problem(path + ": holds NaN or infinity");
    if (path.starts_with("/checksums/")) return;
    const auto expected = expected_.find(path);
    if (expected == expected_.end()) {
      add_problem(path + ": is not in the list of checksums");
    } else {
      seen_.insert(path);
      if (expected->second != hdf5::dataset_checksum(content.unit, content.bytes))
        add_problem(path + ": checksum is wrong");
    }
  }

  Handle file_;
  std::map<std::string, std::uint64_t> expected_;
  std::set<std::string> seen_;
  VerifyReport report_;
};

}  // namespace

VerifyReport verify_result(const Path& path) {
  hdf5::prepare_library();
  try {
    return Verifier(path).run();
  } catch (const StorageError& error) {
    VerifyReport report;
    report.problems.push_back(error.what());
    return report;
  }
}

}  // namespace granary::storage
