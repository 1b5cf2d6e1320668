#include "tests/support/result_reader.h"

#include <stdexcept>

namespace granary::testing {
namespace {

std::string read_text(hid_t attribute, hid_t type) {
  if (H5Tis_variable_str(type) > 0) {
    char* pointer = nullptr;
    H5Aread(attribute, type, &pointer);
    const std::string text = pointer == nullptr ? "" : pointer;
    H5free_memory(pointer);
    return text;
  }
  std::string text(H5Tget_size(type), '\0');
  H5Aread(attribute, type, text.data());
  return text;
}

void read_attributes(hid_t object, const std::string& path, StoredResult& out) {
  H5O_info_t info;
  H5Oget_info2(object, &info, H5O_INFO_NUM_ATTRS);
  for (hsize_t i = 0; i < info.num_attrs; ++i) {
    const hid_t attribute =
        H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, i, H5P_DEFAULT, H5P_DEFAULT);
    char name[256];
    H5Aget_name(attribute, sizeof name, name);
    const hid_t type = H5Aget_type(attribute);
    const std::string key = path + "@" + name;
    if (H5Tget_class(type) == H5T_STRING)
      out.texts[key] = read_text(attribute, type);
    else
      H5Aread(attribute, H5T_NATIVE_DOUBLE, &out.numbers[key]);
    H5Tclose(type);
    H5Aclose(attribute);
  }
}

StoredDataset read_dataset(hid_t dataset) {
  StoredDataset out;
  const hid_t type = H5Dget_type(dataset);
  const hid_t space = H5Dget_space(dataset);
  out.has_data = H5Sget_simple_extent_type(space) != H5S_NULL;
  const int rank = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> extents(rank > 0 ? rank : 0);
  if (rank > 0) H5Sget_simple_extent_dims(space, extents.data(), nullptr);
  out.extents.assign(extents.begin(), extents.end());
  if (out.has_data) {
    out.bytes.resize(H5Sget_simple_extent_npoints(space) * H5Tget_size(type));
    if (!out.bytes.empty() &&
        H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.bytes.data()) < 0)
      throw std::runtime_error("unreadable dataset");
  }
  H5Sclose(space);
  H5Tclose(type);
  return out;
}

struct Walk {
  std::string prefix;
  StoredResult& out;
};

void walk(hid_t group, const std::string& prefix, StoredResult& out);

// Called for every link of a group.
herr_t visit_link(hid_t group, const char* name, const H5L_info_t*, void* data) {
  const auto& [prefix, out] = *static_cast<Walk*>(data);
  const std::string path = prefix + "/" + name;
  const hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  if (object < 0) return -1;
  read_attributes(object, path, out);
  if (H5Iget_type(object) == H5I_GROUP) walk(object, path, out);
  if (H5Iget_type(object) == H5I_DATASET) {
    out.datasets[path] = read_dataset(object);
    const auto units = out.texts.find(path + "@units");
    if (units != out.texts.end()) out.datasets[path].units = units->second;
  }
  H5Oclose(object);
  return 0;
}

void walk(hid_t group, const std::string& prefix, StoredResult& out) {
  Walk data{prefix, out};
  if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit_link, &data) < 0)
    throw std::runtime_error("cannot open what is in " + prefix);
}

}  // namespace

std::string StoredDataset::text() const {
  const std::string all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return all.substr(0, all.find('\0'));
}

std::map<std::string, StoredDataset> StoredResult::below(const std::string& prefix) const {
  std::map<std::string, StoredDataset> found;
  for (const auto& [path, dataset] : datasets)
    if (path.rfind(prefix, 0) == 0) found[path] = dataset;
  return found;
}

StoredResult read_result(const std::filesystem::path& path) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) throw std::runtime_error("HDF5 cannot open " + path.string());
  StoredResult out;
  read_attributes(file, "", out);
  walk(file, "", out);
  H5Fclose(file);
  return out;
}

bool operator==(const StoredDataset& a, const StoredDataset& b) {
  return a.units == b.units && a.bytes == b.bytes && a.extents == b.extents;
}

}  // namespace granary::testing
