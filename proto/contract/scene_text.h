// Scenes as people write them: protobuf text format or JSON (told apart by the first character).
// Strict: unknown keys, wrong types and syntax errors give one line with file, line, field path and
// the nearest known name.
#pragma once

#include <google/protobuf/message.h>

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

inline constexpr std::size_t kMaxSceneBytes = 16u << 20;  // larger input is refused unread

struct ParsedScene {
  v1::Scene scene;
  std::map<std::string, int> line_of;  // field path -> line, for errors found later
};

Result<ParsedScene> parse_scene(std::string_view text, std::string_view file_name);

// The same for any message of ours: fills `message`, returns the lines of its fields.
Result<std::map<std::string, int>> parse_message(std::string_view text, std::string_view file_name,
                                                 google::protobuf::Message& message);

using FieldSetting = std::pair<std::string, std::string>;  // path, value of --set

// Parse, apply settings, validate (scene_rules.h). Errors read "file:line: path: what".
Result<v1::Scene> load_scene(std::string_view text, std::string_view file_name,
                             std::span<const FieldSetting> settings);

std::string scene_to_text(const v1::Scene& scene);
std::string scene_to_json(const v1::Scene& scene);  // field names as in the text format

}  // namespace granary
