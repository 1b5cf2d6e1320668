// One scalar out of a stored scene, found by walking the wire format without building the message:
// a column over a million jobs must not parse a million scenes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

namespace granary::server {

// Nothing when the field is not set; enums give their name, booleans 0 and 1.
using SceneScalar = std::variant<std::monostate, std::int64_t, double, std::string>;

class SceneField {
 public:
  // "chute.particles[0].diameter_m"; a path that names no field finds nothing.
  explicit SceneField(std::string_view path);
  SceneField(SceneField&&) noexcept;
  ~SceneField();

  SceneScalar in(const void* scene, int size_bytes) const;

 private:
  struct Steps;
  std::unique_ptr<Steps> steps_;
};

}  // namespace granary::server
