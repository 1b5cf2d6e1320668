// Any bytes as a scene: refused with one line, or a scene that survives being written and read again.
#include <cstdint>
#include <string_view>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto scene = granary::load_scene(text, "scene.txtpb", {});
  if (!scene) return require_one_line(scene.error()), 0;
  const auto resolved = granary::resolve(*scene);
  if (!resolved) return require_one_line(resolved.error()), 0;
  const std::string key = granary::job_key(resolved->scene);
  for (const std::string& written : {granary::scene_to_text(*scene), granary::scene_to_json(*scene)}) {
    const auto again = granary::load_scene(written, "again", {});
    require(again.ok(), "what was written can be read");
    const auto resolved_again = granary::resolve(*again);
    require(resolved_again.ok() && granary::job_key(resolved_again->scene) == key, "and is the same job");
  }
  return 0;
}
