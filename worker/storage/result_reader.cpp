#include "worker/storage/result_reader.h"

#include <algorithm>
#include <optional>

#include "worker/storage/hdf5_handle.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using hdf5::check;
using hdf5::Handle;

std::vector<std::string> links_of(hid_t group) {
  H5G_info_t info;
  check(H5Gget_info(group, &info), "list a group");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t length =
        H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT);
    std::string name(static_cast<std::size_t>(std::max<ssize_t>(length, 0)) + 1, '\0');
    H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(),
                       H5P_DEFAULT);
    name.pop_back();
    names.push_back(std::move(name));
  }
  return names;
}

// Numbers in one or two dimensions; nothing for texts and groups.
std::optional<NumberColumn> read_numbers(hid_t group, const std::string& name) {
  const Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name);
  if (H5Iget_type(object) != H5I_DATASET) return std::nullopt;
  const Handle type(H5Dget_type(object), H5Tclose, "read type of " + name);
  const Handle space(H5Dget_space(object), H5Sclose, "read shape of " + name);
  const H5T_class_t type_class = H5Tget_class(type);
  const int rank = H5Sget_simple_extent_ndims(space);
  if ((type_class != H5T_FLOAT && type_class != H5T_INTEGER) || rank < 1 || rank > 2)
    return std::nullopt;
  hsize_t extents[2] = {0, 1};
  check(H5Sget_simple_extent_dims(space, extents, nullptr), "read extents of " + name);
  NumberColumn column{name, static_cast<std::size_t>(extents[1]), {}};
  column.values.resize(static_cast<std::size_t>(extents[0] * extents[1]));
  if (!column.values.empty())
    check(H5Dread(object, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.values.data()),
          "read " + name);
  return column;
}

std::string text_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return "";
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, std::string("open ") + name);
  const Handle type(H5Aget_type(attribute), H5Tclose, std::string("read type of ") + name);
  if (H5Tis_variable_str(type) <= 0) return "";
  char* text = nullptr;
  check(H5Aread(attribute, type, &text), std::string("read ") + name);
  const std::string copy = text ? text : "";
  check(H5free_memory(text), "free a text");
  return copy;
}

double number_attribute(hid_t object, const char* name) {
  double value = 0;
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, std::string("open ") + name);
  check(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), std::string("read ") + name);
  return value;
}

NumberTable read_table(hid_t group, std::string name) {
  NumberTable table{std::move(name), {}};
  for (const std::string& link : links_of(group))
    if (auto column = read_numbers(group, link)) table.columns.push_back(std::move(*column));
  return table;
}

Handle open_group(hid_t parent, const std::string& name) {
  return Handle(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "open " + name);
}

Handle open_file(const Path& path) {
  hdf5::prepare_library();
  if (H5Fis_hdf5(path.c_str()) <= 0)
    throw StorageError(StorageFault::damaged, path.string() + " is not an HDF5 file");
  return Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose,
                "open " + path.string());
}

}  // namespace

const NumberColumn* NumberTable::find(std::string_view column) const {
  for (const NumberColumn& each : columns)
    if (each.name == column) return &each;
  return nullptr;
}

const NumberColumn& NumberTable::required(std::string_view column) const {
  if (const NumberColumn* found = find(column)) return *found;
  throw StorageError(StorageFault::damaged, name + " has no column " + std::string(column));
}

void check_lengths(const std::string& name, std::span<const NumberColumn> columns) {
  for (const NumberColumn& column : columns)
    if (column.rows() != columns[0].rows())
      throw StorageError(StorageFault::damaged, name + ": columns differ in length");
}

struct ResultReader::File {
  explicit File(const Path& path) : file(open_file(path)) {
    if (H5Lexists(file, "/frames", H5P_DEFAULT) > 0) frames = links_of(open_group(file, "/frames"));
  }
  Handle file;
  std::vector<std::string> frames;
};

ResultReader::ResultReader(const Path& result) : file_(std::make_unique<File>(result)) {}
ResultReader::~ResultReader() = default;

std::string ResultReader::kind() const {
  const Handle root = open_group(file_->file, "/");
  return text_attribute(root, "kind");
}

std::vector<std::string> ResultReader::table_names(std::string_view group) const {
  const std::string path = "/" + std::string(group);
  if (H5Lexists(file_->file, path.c_str(), H5P_DEFAULT) <= 0) return {};
  return links_of(open_group(file_->file, path));
}

NumberTable ResultReader::table(std::string_view group, const std::string& name) const {
  return read_table(open_group(file_->file, "/" + std::string(group) + "/" + name), name);
}

std::size_t ResultReader::frame_count() const { return file_->frames.size(); }

StoredFrame ResultReader::frame(std::size_t index) const {
  const Handle group = open_group(file_->file, "/frames/" + file_->frames.at(index));
  return {number_attribute(group, "time_s"), text_attribute(group, "phase"),
          read_table(group, file_->frames[index])};
}

}  // namespace granary::storage
