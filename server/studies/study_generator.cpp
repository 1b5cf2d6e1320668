#include "server/studies/study_generator.h"

#include "proto/contract/field_path.h"
#include "proto/contract/scene_rules.h"
#include "server/studies/optimize.h"
#include "server/studies/ablate.h"
#include "server/studies/price.h"
#include "server/studies/sweep.h"

namespace granary::server {

Status StudyGenerator::extend(std::uint32_t) {
  return Error{ErrorCode::failed_precondition,
               "this study has a fixed plan and cannot be extended: submit another one", "budget"};
}

std::string_view kind_of(const v1::StudySpec& spec) {
  switch (spec.kind_case()) {
    case v1::StudySpec::kSweep:
      return "sweep";
    case v1::StudySpec::kOptimize:
      return "optimize";
    case v1::StudySpec::kPrice:
      return "price";
    case v1::StudySpec::kAblate:
      return "ablate";
    case v1::StudySpec::KIND_NOT_SET:
      break;
  }
  return "";
}

Result<v1::Scene> scene_with(const v1::Scene& base,
                             const std::map<std::string, std::string>& inputs) {
  v1::Scene scene = base;
  for (const auto& [path, value] : inputs)
    if (Status set = set_field(scene, path, value); !set) return set.error();
  return scene;
}

std::string label_of(const std::map<std::string, std::string>& inputs) {
  std::string label;
  for (const auto& [path, value] : inputs) {
    const auto dot = path.rfind('.');
    if (!label.empty()) label += ' ';
    label += path.substr(dot == std::string::npos ? 0 : dot + 1) + "=" + value;
  }
  return label;
}

Result<std::unique_ptr<StudyGenerator>> make_generator(const v1::StudySpec& spec) {
  if (granary::kind_of(spec.scene()).empty())
    return Error{ErrorCode::invalid_argument, "scene: is empty: a study needs a base scene",
                 "scene"};
  if (spec.has_scene_file() || spec.set_size() > 0)
    return Error{ErrorCode::invalid_argument,
                 "scene_file and set are for files: the client puts the scene in", "scene_file"};
  switch (spec.kind_case()) {
    case v1::StudySpec::kSweep:
      return make_sweep(spec);
    case v1::StudySpec::kOptimize:
      return make_optimize(spec);
    case v1::StudySpec::kPrice:
      return make_price(spec);
    case v1::StudySpec::kAblate:
      return make_ablate(spec);
    case v1::StudySpec::KIND_NOT_SET:
      break;
  }
  return Error{ErrorCode::invalid_argument,
               "the study says nothing of sweep, optimize, price and ablate", "kind"};
}

}  // namespace granary::server
