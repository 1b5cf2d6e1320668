#include "worker/storage/frame_export.h"

#include <openssl/evp.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "worker/storage/export_files.h"
#include "worker/storage/result_reader.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

// Viewers know these by name; every other column keeps its own, with its unit.
struct KnownName {
  const char* column;
  const char* xyz;
};
constexpr KnownName kXyzNames[] = {
    {"position_m", "pos"}, {"velocity_m_per_s", "velo"}, {"radius_m", "radius"}, {"id", "id"}};

const NumberColumn& positions(const StoredFrame& frame) {
  return frame.grains.required("position_m");
}

// Plane vectors get a third component: viewers know only space.
std::size_t shown_width(const NumberColumn& column) {
  return column.width == 2 ? 3 : column.width;
}

double component(const NumberColumn& column, std::size_t row, std::size_t k) {
  return k < column.width ? column.values[row * column.width + k] : 0;
}

// ------------------------------------------------------------------------------------ extended XYZ

std::string xyz_name(const NumberColumn& column) {
  for (const KnownName& known : kXyzNames)
    if (column.name == known.column) return known.xyz;
  return column.name;
}

// Nine digits tell any two Float32 apart.
void append_number(std::string& text, double value) {
  char digits[32];
  text.append(
      digits,
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 9).ptr);
}

std::string xyz_block(const StoredFrame& frame) {
  std::vector<const NumberColumn*> columns;
  for (const NumberColumn& column : frame.grains.columns) columns.push_back(&column);
  // Position first: the readers of plain XYZ expect it there.
  std::stable_partition(columns.begin(), columns.end(),
                        [](const NumberColumn* column) { return column->name == "position_m"; });
  const std::size_t rows = positions(frame).rows();
  std::string text = std::to_string(rows) + "\nProperties=";
  for (std::size_t k = 0; k < columns.size(); ++k)
    text += (k > 0 ? ":" : "") + xyz_name(*columns[k]) +
            ":R:" + std::to_string(shown_width(*columns[k]));
  text += " Time=";
  append_number(text, frame.time_s);
  text += " phase=\"" + frame.phase + "\" pbc=\"F F F\"\n";
  for (std::size_t row = 0; row < rows; ++row) {
    for (const NumberColumn* column : columns)
      for (std::size_t k = 0; k < shown_width(*column); ++k) {
        if (text.back() != '\n') text += ' ';
        append_number(text, component(*column, row, k));
      }
    text += '\n';
  }
  return text;
}

// ---------------------------------------------------------------------------------------- ParaView

// VTK's inline binary: base64 of the number of bytes (UInt32) followed by the bytes.
template <typename Number>
std::string base64(const std::vector<Number>& numbers) {
  const auto size = static_cast<std::uint32_t>(numbers.size() * sizeof(Number));
  std::vector<unsigned char> bytes(sizeof size + size);
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, numbers.data(), size);
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  text.resize(
      static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                               bytes.data(), static_cast<int>(bytes.size()))));
  return text;
}

template <typename Number>
std::string data_array(const char* type, const std::string& name, std::size_t width,
                       const std::vector<Number>& numbers) {
  return "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
         "\" NumberOfComponents=\"" + std::to_string(width) + "\" format=\"binary\">" +
         base64(numbers) + "</DataArray>\n";
}

std::string column_array(const NumberColumn& column) {
  std::vector<float> numbers;
  numbers.reserve(column.rows() * shown_width(column));
  for (std::size_t row = 0; row < column.rows(); ++row)
    for (std::size_t k = 0; k < shown_width(column); ++k)
      numbers.push_back(static_cast<float>(component(column, row, k)));
  return data_array("Float32", column.name, shown_width(column), numbers);
}

// One vertex per particle, so that something is seen before any glyph is chosen.
std::string vertices(std::size_t count) {
  std::vector<std::int32_t> connectivity(count), offsets(count);
  for (std::size_t i = 0; i < count; ++i) {
    connectivity[i] = static_cast<std::int32_t>(i);
    offsets[i] = static_cast<std::int32_t>(i + 1);
  }
  return "<Verts>\n" + data_array("Int32", "connectivity", 1, connectivity) +
         data_array("Int32", "offsets", 1, offsets) + "</Verts>\n";
}

std::string vtp_text(const StoredFrame& frame) {
  const std::size_t count = positions(frame).rows();
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" "
      "header_type=\"UInt32\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      std::to_string(count) + "\" NumberOfVerts=\"" + std::to_string(count) + "\">\n<Points>\n" +
      column_array(positions(frame)) + "</Points>\n" + vertices(count) +
      "<PointData Scalars=\"radius_m\">\n";
  for (const NumberColumn& column : frame.grains.columns)
    if (column.name != "position_m") text += column_array(column);
  return text + "</PointData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

std::string pvd_line(double time_s, const std::string& file) {
  char time[32];
  std::snprintf(time, sizeof time, "%.9g", time_s);
  return std::string("<DataSet timestep=\"") + time + "\" file=\"" + file + "\"/>\n";
}

StoredFrame checked_frame(const ResultReader& reader, std::size_t index) {
  StoredFrame frame = reader.frame(index);
  check_lengths(frame.grains.name, frame.grains.columns);
  return frame;
}

void require_frames(const ResultReader& reader) {
  if (reader.frame_count() == 0)
    throw StorageError(StorageFault::missing,
                       "there are no frames: submit the scene with output.frames = 100");
}

}  // namespace

std::vector<Path> export_xyz(const Path& result, const Path& directory) {
  const ResultReader reader(result);
  require_frames(reader);
  make_directory(directory);
  const Path path = directory / "frames.xyz";
  std::ofstream file(path, std::ios::binary);
  for (std::size_t index = 0; index < reader.frame_count(); ++index)
    file << xyz_block(checked_frame(reader, index));
  file.close();
  if (!file) throw StorageError(StorageFault::io, path.string() + " cannot be written");
  return {path};
}

std::vector<Path> export_paraview(const Path& result, const Path& directory) {
  const ResultReader reader(result);
  require_frames(reader);
  make_directory(directory / "frames");
  std::string collection =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
  std::vector<Path> written = {directory / "frames.pvd"};
  for (std::size_t index = 0; index < reader.frame_count(); ++index) {
    const StoredFrame frame = checked_frame(reader, index);
    const std::string file = "frames/" + frame.grains.name + ".vtp";
    written.push_back(directory / file);
    write_text(written.back(), vtp_text(frame));
    collection += pvd_line(frame.time_s, file);
  }
  write_text(written[0], collection + "</Collection>\n</VTKFile>\n");
  return written;
}

}  // namespace granary::storage
