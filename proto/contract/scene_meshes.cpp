#include "proto/contract/scene_meshes.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "proto/contract/rule_text.h"
#include "proto/contract/stl.h"

namespace granary {
namespace {

Result<std::string> read_file(const std::filesystem::path& file, const std::string& path) {
  std::error_code failed;
  const std::string name = "= \"" + file.string() + "\" ";
  if (!std::filesystem::is_regular_file(file, failed))
    return refuse(path,
                  name + (failed || !std::filesystem::exists(file, failed) ? "is not there"
                                                                           : "is no regular file"));
  const auto size = std::filesystem::file_size(file, failed);
  if (failed || size > kMaxStlBytes)
    return refuse(path, name + "has " + std::to_string(size) +
                            " bytes, must be <= " + std::to_string(kMaxStlBytes));
  std::ifstream in(file, std::ios::binary);
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) return refuse(path, name + "cannot be read");
  return bytes;
}

Status add_triangles(v1::Chute& chute, const v1::Mesh& mesh, const std::filesystem::path& folder,
                     const std::string& path) {
  if (mesh.stl_file().empty()) return refuse(path + ".stl_file", "is missing: the name of a file");
  const std::string field = path + ".stl_file";
  auto bytes = read_file(folder / mesh.stl_file(), field);
  if (!bytes) return bytes.error();
  const auto triangles = parse_stl(*bytes, field + ": " + mesh.stl_file());
  if (!triangles) return Error{triangles.error().code, triangles.error().message, field};
  const double unit = mesh.has_unit_m() ? mesh.unit_m() : 1;
  for (const TriangleCorners& corners : *triangles) {
    v1::Triangle* triangle = chute.add_triangles();
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const int axis = static_cast<int>(k % 3);
      const double offset = mesh.offset_m_size() == 3 ? mesh.offset_m(axis) : 0;
      triangle->add_vertices_m(corners[k] * unit + offset);
    }
  }
  return Done{};
}

}  // namespace

Status inline_meshes(v1::Scene& scene, const std::string& scene_file) {
  if (!scene.has_chute()) return Done{};
  v1::Chute& chute = *scene.mutable_chute();
  const std::filesystem::path folder = std::filesystem::path(scene_file).parent_path();
  for (int k = 0; k < chute.meshes_size(); ++k) {
    const std::string path = "chute.meshes[" + std::to_string(k) + "]";
    if (Status status = add_triangles(chute, chute.meshes(k), folder, path); !status) return status;
  }
  chute.clear_meshes();
  return Done{};
}

}  // namespace granary
