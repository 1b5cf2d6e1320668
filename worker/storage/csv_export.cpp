#include "worker/storage/csv_export.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "worker/storage/hdf5_handle.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using hdf5::check;
using hdf5::Handle;

// Files whose columns and their order are part of the product's contract; all others have every
// dataset of the group, time first, then by name.
struct FixedColumns {
  std::string_view table;
  std::array<std::string_view, 4> columns;  // "" = no more
};
constexpr FixedColumns kFixedColumns[] = {
    {"remaining", {"angle_deg", "remaining_percent"}},
    {"cg", {"time_s", "angle_deg", "x_m", "y_m"}},
    {"surface_velocity", {"x_m", "y_m", "streamwise_m_per_s", "spanwise_m_per_s"}},
    {"bed_height", {"x_m", "y_m", "height_m"}},
    {"depth_profile", {"x_m", "height_m", "streamwise_m_per_s", "solid_fraction"}},
};

struct NamedColumn {
  std::string name;
  std::vector<double> values;
};

std::vector<std::string> links_of(hid_t group) {
  H5G_info_t info;
  check(H5Gget_info(group, &info), "list a group");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t length = H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr,
                                              0, H5P_DEFAULT);
    std::string name(static_cast<std::size_t>(std::max<ssize_t>(length, 0)) + 1, '\0');
    H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(),
                       H5P_DEFAULT);
    name.pop_back();
    names.push_back(std::move(name));
  }
  return names;
}

// One-dimensional numbers; nothing for texts, matrices and groups.
std::optional<std::vector<double>> read_numbers(hid_t group, const std::string& name) {
  const Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name);
  if (H5Iget_type(object) != H5I_DATASET) return std::nullopt;
  const Handle type(H5Dget_type(object), H5Tclose, "read type of " + name);
  const Handle space(H5Dget_space(object), H5Sclose, "read shape of " + name);
  const H5T_class_t type_class = H5Tget_class(type);
  if (type_class != H5T_FLOAT && type_class != H5T_INTEGER) return std::nullopt;
  if (H5Sget_simple_extent_ndims(space) != 1) return std::nullopt;
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  if (!values.empty())
    check(H5Dread(object, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "read " + name);
  return values;
}

std::vector<std::string> column_names(const std::string& table, std::vector<std::string> links) {
  for (const FixedColumns& fixed : kFixedColumns) {
    if (fixed.table != table) continue;
    std::vector<std::string> names(fixed.columns.begin(), fixed.columns.end());
    names.erase(std::remove(names.begin(), names.end(), ""), names.end());
    return names;
  }
  std::stable_partition(links.begin(), links.end(),
                        [](const std::string& name) { return name == "time_s"; });
  return links;
}

std::vector<NamedColumn> read_table(hid_t tables, const std::string& table) {
  const Handle group(H5Gopen2(tables, table.c_str(), H5P_DEFAULT), H5Gclose, "open " + table);
  std::vector<NamedColumn> columns;
  for (const std::string& name : column_names(table, links_of(group))) {
    if (H5Lexists(group, name.c_str(), H5P_DEFAULT) <= 0) continue;
    auto values = read_numbers(group, name);
    if (!values) continue;
    if (!columns.empty() && values->size() != columns[0].values.size())
      throw StorageError(StorageFault::damaged, table + ": columns differ in length");
    columns.push_back({name, std::move(*values)});
  }
  return columns;
}

// Shortest text that reads back to the same bits.
void append_number(std::string& text, double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

std::string csv_text(const std::vector<NamedColumn>& columns) {
  std::string text;
  for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].name;
  text += '\n';
  for (std::size_t row = 0; row < columns[0].values.size(); ++row) {
    const bool has_data = std::all_of(columns.begin(), columns.end(), [&](const NamedColumn& c) {
      return std::isfinite(c.values[row]);
    });
    if (!has_data) continue;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (k > 0) text += ',';
      append_number(text, columns[k].values[row]);
    }
    text += '\n';
  }
  return text;
}

void write_text(const Path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw StorageError(StorageFault::io, path.string() + " cannot be written");
}

void export_group(hid_t file, const char* name, const Path& directory, std::vector<Path>& written) {
  if (H5Lexists(file, name, H5P_DEFAULT) <= 0) return;
  const Handle tables(H5Gopen2(file, name, H5P_DEFAULT), H5Gclose, std::string("open ") + name);
  for (const std::string& table : links_of(tables)) {
    const auto columns = read_table(tables, table);
    if (columns.empty()) continue;
    written.push_back(directory / (table + ".csv"));
    write_text(written.back(), csv_text(columns));
  }
}

}  // namespace

std::vector<Path> export_csv(const Path& result, const Path& directory) {
  hdf5::silence_library();
  if (H5Fis_hdf5(result.c_str()) <= 0)
    throw StorageError(StorageFault::damaged, result.string() + " is not an HDF5 file");
  const Handle file(H5Fopen(result.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose,
                    "open " + result.string());
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) throw StorageError(StorageFault::io, directory.string() + ": " + failure.message());
  std::vector<Path> written;
  export_group(file, "/series", directory, written);
  export_group(file, "/fields", directory, written);
  return written;
}

}  // namespace granary::storage
