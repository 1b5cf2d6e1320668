// What a scene may say: range, default and meaning of every field, and the rules between fields.
// One table serves validation, defaults, `scene new` and the documents.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

enum class Presence {
  required,   // the user must say it
  defaulted,  // `fallback` when absent
  chosen,     // resolve() chooses it from the scene
  optional    // absent means "not there"
};

struct FieldRule {
  std::string_view path;  // lists as "particles[]"
  Presence presence;
  double fallback;  // numbers and booleans; enums by number
  double minimum;
  double maximum;
  bool open_minimum;  // the minimum itself is not allowed
  std::string_view meaning;
};

std::span<const FieldRule> scene_rules();
const FieldRule* find_rule(std::string_view pattern);

// "> 0 and <= 1"
std::string range_text(const FieldRule& rule);

// Every set field finite and inside its range, everything required there, fields consistent with
// each other. The error's field_path names the field, its message starts with that path.
Status validate_scene(const v1::Scene& scene);

std::string_view kind_of(const v1::Scene& scene);  // "discharge", "chute" or ""

}  // namespace granary
