// Internal to worker/storage: datasets with units and checksums, groups and attributes, in the file
// format of HDF5 1.8 (its object headers and indices carry checksums of their own).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/core/column.h"
#include "worker/storage/file_system.h"
#include "worker/storage/hdf5_handle.h"

namespace granary::storage::hdf5 {

class FileWriter {
 public:
  explicit FileWriter(const Path& path);

  void create_group(const std::string& path);
  // The same, kept open: many datasets in one group are found faster below it than from the root.
  Handle open_new_group(const std::string& path);
  void write_column_in(hid_t group, const std::string& group_path, const core::ColumnView& column);
  void link_in(hid_t group, const std::string& existing_path, const std::string& name);
  void set_attribute_of(hid_t object, const char* name, double value);
  void set_attribute_of(hid_t object, const char* name, std::string_view text);

  void write_column(const std::string& path, const core::ColumnView& column);
  void write_scalar(const std::string& path, std::string_view unit, double value);
  void write_unknown(const std::string& path, std::string_view unit);  // null dataspace: no value
  void write_text(const std::string& path, std::string_view text);
  void write_texts(const std::string& path, std::span<const std::string> texts);

  void set_attribute(const std::string& path, const char* name, double value);
  void set_attribute(const std::string& path, const char* name, std::uint64_t value);
  void set_attribute(const std::string& path, const char* name, std::string_view text);

  // Writes /checksums and closes the file.
  void finish();

 private:
  // `name` below `place`; `path` is its full path.
  void write_dataset(hid_t place, const std::string& name, const std::string& path, hid_t type,
                     hid_t space, std::string_view unit, std::span<const std::byte> bytes);
  void write_checksums();

  Handle file_;
  Handle dataset_options_;
  Handle scalar_space_;
  Handle text_type_;  // variable length UTF-8, for attributes
  std::vector<std::string> checksum_paths_;
  std::vector<std::uint64_t> checksums_;
};

// Little-endian file type of an element type; never to be closed.
hid_t file_type_of(core::ElementType type);

// Of one dataset: its units (or "1" when empty) and its bytes as stored.
std::uint64_t dataset_checksum(std::string_view unit, std::span<const std::byte> bytes);

}  // namespace granary::storage::hdf5
