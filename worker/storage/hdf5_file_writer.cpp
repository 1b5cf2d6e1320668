#include "worker/storage/hdf5_file_writer.h"

#include <algorithm>
#include <cstring>

#include "worker/storage/checksum.h"

namespace granary::storage::hdf5 {
namespace {

// Metadata is gathered into blocks of this size: fewer, larger writes for many small datasets.
constexpr hsize_t kMetadataBlockBytes = 1 << 13;
constexpr std::string_view kTextUnit = "text";

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "prepare a result file");
  check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "set the format version");
  check(H5Pset_meta_block_size(access, kMetadataBlockBytes), "set the metadata block size");
  // Only this process knows the temporary name, and network file systems may refuse locks.
  check(H5Pset_file_locking(access, false, true), "switch file locking off");
  return access;
}

Handle create_file(const Path& path) {
  prepare_library();
  const Handle access = file_access();
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
                "create " + path.string());
}

Handle dataset_options() {
  Handle options(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "prepare datasets");
  // Without time stamps and fill values the same run gives the same bytes, and sooner.
  check(H5Pset_obj_track_times(options, false), "switch time stamps off");
  check(H5Pset_fill_time(options, H5D_FILL_TIME_NEVER), "switch fill values off");
  return options;
}

Handle variable_text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "prepare text");
  check(H5Tset_size(type, H5T_VARIABLE), "prepare text");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "prepare text");
  return type;
}

Handle fixed_text_type(std::size_t byte_count) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "prepare text");
  check(H5Tset_size(type, byte_count), "prepare text");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "prepare text");
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), "prepare text");
  return type;
}

Handle simple_space(std::span<const hsize_t> extents) {
  return Handle(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr),
                H5Sclose, "shape a dataset");
}

Handle space_of(const core::ColumnView& column) {
  const hsize_t extents[2] = {column.rows, column.width};
  return simple_space(std::span(extents, column.width == 1 ? 1 : 2));
}

}  // namespace

hid_t file_type_of(core::ElementType type) {
  switch (type) {
    case core::ElementType::f32:
      return H5T_IEEE_F32LE;
    case core::ElementType::f64:
      return H5T_IEEE_F64LE;
    case core::ElementType::i32:
      return H5T_STD_I32LE;
    case core::ElementType::i64:
      return H5T_STD_I64LE;
    case core::ElementType::u32:
      return H5T_STD_U32LE;
    case core::ElementType::u64:
      return H5T_STD_U64LE;
    case core::ElementType::u8:
      return H5T_STD_U8LE;
  }
  return -1;
}

std::uint64_t dataset_checksum(std::string_view unit, std::span<const std::byte> bytes) {
  RunningChecksum checksum;
  checksum.add(std::as_bytes(std::span(unit)));
  checksum.add(bytes);
  return checksum.value();
}

FileWriter::FileWriter(const Path& path)
    : file_(create_file(path)),
      dataset_options_(dataset_options()),
      scalar_space_(H5Screate(H5S_SCALAR), H5Sclose, "shape a scalar"),
      text_type_(variable_text_type()) {}

Handle FileWriter::open_new_group(const std::string& path) {
  return Handle(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                "create group " + path);
}

void FileWriter::create_group(const std::string& path) {
  open_new_group(path);
}

void FileWriter::write_dataset(hid_t place, const std::string& name, const std::string& path,
                               hid_t type, hid_t space, std::string_view unit,
                               std::span<const std::byte> bytes) {
  if (unit.empty()) unit = "1";
  {
    Handle dataset(
        H5Dcreate2(place, name.c_str(), type, space, H5P_DEFAULT, dataset_options_, H5P_DEFAULT),
        H5Dclose, "create " + path);
    if (!bytes.empty())
      check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), "write " + path);
    const Handle attribute(
        H5Acreate2(dataset, "units", text_type_, scalar_space_, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
        "create units of " + path);
    const std::string text(unit);
    const char* pointer = text.c_str();
    check(H5Awrite(attribute, text_type_, &pointer), "write units of " + path);
    dataset.close("close " + path);
  }
  checksum_paths_.push_back(path);
  checksums_.push_back(dataset_checksum(unit, bytes));
}

void FileWriter::write_column(const std::string& path, const core::ColumnView& column) {
  const auto* data = static_cast<const std::byte*>(column.data);
  write_dataset(file_, path, path, file_type_of(column.type), space_of(column), column.unit,
                {data, column.size_bytes()});
}

void FileWriter::write_column_in(hid_t group, const std::string& group_path,
                                 const core::ColumnView& column) {
  const auto* data = static_cast<const std::byte*>(column.data);
  const std::string name(column.name);
  write_dataset(group, name, group_path + "/" + name, file_type_of(column.type), space_of(column),
                column.unit, {data, column.size_bytes()});
}

void FileWriter::write_scalar(const std::string& path, std::string_view unit, double value) {
  write_dataset(file_, path, path, H5T_IEEE_F64LE, scalar_space_, unit,
                std::as_bytes(std::span<const double>(&value, 1)));
}

void FileWriter::write_unknown(const std::string& path, std::string_view unit) {
  const Handle nothing(H5Screate(H5S_NULL), H5Sclose, "shape an unknown value");
  write_dataset(file_, path, path, H5T_IEEE_F64LE, nothing, unit, {});
}

void FileWriter::write_text(const std::string& path, std::string_view text) {
  std::string stored(text);
  if (stored.empty()) stored.push_back('\0');  // HDF5 has no text of length 0
  const Handle type = fixed_text_type(stored.size());
  write_dataset(file_, path, path, type, scalar_space_, kTextUnit,
                std::as_bytes(std::span(stored)));
}

void FileWriter::write_texts(const std::string& path, std::span<const std::string> texts) {
  std::size_t longest = 1;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  std::string stored(longest * texts.size(), '\0');
  for (std::size_t i = 0; i < texts.size(); ++i)
    std::memcpy(stored.data() + i * longest, texts[i].data(), texts[i].size());
  const hsize_t rows = texts.size();
  const Handle type = fixed_text_type(longest);
  write_dataset(file_, path, path, type, simple_space({&rows, 1}), kTextUnit,
                std::as_bytes(std::span(stored)));
}

void FileWriter::link_in(hid_t group, const std::string& existing_path, const std::string& name) {
  check(H5Lcreate_hard(file_, existing_path.c_str(), group, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
        "link " + name + " to " + existing_path);
}

namespace {

void write_attribute(hid_t object, const char* name, hid_t type, hid_t space, const void* value) {
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         std::string("create attribute ") + name);
  check(H5Awrite(attribute, type, value), std::string("write attribute ") + name);
}

Handle open_object(hid_t file, const std::string& path) {
  return Handle(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, "open " + path);
}

}  // namespace

void FileWriter::set_attribute_of(hid_t object, const char* name, double value) {
  write_attribute(object, name, H5T_IEEE_F64LE, scalar_space_, &value);
}
void FileWriter::set_attribute_of(hid_t object, const char* name, std::string_view text) {
  const std::string stored(text);
  const char* pointer = stored.c_str();
  write_attribute(object, name, text_type_, scalar_space_, &pointer);
}
void FileWriter::set_attribute(const std::string& path, const char* name, double value) {
  set_attribute_of(open_object(file_, path), name, value);
}
void FileWriter::set_attribute(const std::string& path, const char* name, std::uint64_t value) {
  write_attribute(open_object(file_, path), name, H5T_STD_U64LE, scalar_space_, &value);
}
void FileWriter::set_attribute(const std::string& path, const char* name, std::string_view text) {
  set_attribute_of(open_object(file_, path), name, text);
}

void FileWriter::write_checksums() {
  // Taken before writing: the list does not list itself.
  const std::vector<std::string> paths = checksum_paths_;
  const std::vector<std::uint64_t> checksums = checksums_;
  create_group("/checksums");
  write_texts("/checksums/path", paths);
  write_column("/checksums/xxh3",
               {"xxh3", "1", core::ElementType::u64, checksums.size(), 1, checksums.data()});
}

void FileWriter::finish() {
  write_checksums();
  file_.close("close the result file");
}

}  // namespace granary::storage::hdf5
