#include "client/commands/study_file.h"

#include <filesystem>

#include "client/commands/submission.h"
#include "proto/contract/field_path.h"
#include "proto/contract/scene_rules.h"
#include "proto/contract/scene_text.h"

namespace granary::commands {
namespace {

namespace fs = std::filesystem;

// The scene that scene_file names, relative to the study's own file.
Status read_scene_file(const std::string& study_path, v1::StudySpec& spec) {
  if (!spec.has_scene_file()) return Done{};
  if (spec.has_scene())
    return Error{ErrorCode::invalid_argument, study_path + ": has both scene and scene_file",
                 "scene_file"};
  const fs::path folder = study_path == "-" ? fs::path() : fs::path(study_path).parent_path();
  const std::string path = (folder / spec.scene_file()).string();
  auto text = read_input(path);
  if (!text) return text.error();
  auto parsed = parse_scene(*text, path);
  if (!parsed) return parsed.error();
  *spec.mutable_scene() = std::move(parsed->scene);
  spec.clear_scene_file();
  return Done{};
}

Status apply(const std::string& setting, v1::Scene& scene) {
  const auto equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    return Error{ErrorCode::invalid_argument, "set '" + setting + "' is not of the form path=value",
                 ""};
  return set_field(scene, setting.substr(0, equals), setting.substr(equals + 1));
}

}  // namespace

void add_study_file_options(CLI::App& verb, StudyFileOptions& options) {
  verb.add_option("STUDY", options.path, "study file, protobuf text or JSON; - reads stdin")
      ->required()
      ->type_name("");
  verb.add_option("--set", options.settings, "set a field of its scene: path=value (repeatable)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
}

Result<v1::StudySpec> load_study(const StudyFileOptions& options) {
  auto text = read_input(options.path);
  if (!text) return text.error();
  v1::StudySpec spec;
  if (auto lines = parse_message(*text, options.path, spec); !lines) return lines.error();
  if (Status status = read_scene_file(options.path, spec); !status) return status.error();
  for (const std::string& setting : spec.set())
    if (Status status = apply(setting, *spec.mutable_scene()); !status) return status.error();
  spec.clear_set();
  for (const std::string& setting : options.settings)
    if (Status status = apply(setting, *spec.mutable_scene()); !status) return status.error();
  if (Status status = validate_scene(spec.scene()); !status)
    return Error{status.error().code, options.path + ": scene: " + status.error().message,
                 status.error().field_path};
  return spec;
}

}  // namespace granary::commands
