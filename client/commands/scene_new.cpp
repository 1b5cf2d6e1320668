// granary scene new: a commented starting scene. The comments (meaning, range, default) come from
// the contract's rules, so they never differ from what validation says.
#include <cmath>
#include <filesystem>
#include <sstream>
#include <vector>

#include "client/commands/catalogue.h"
#include "proto/contract/scene_rules.h"

namespace granary::commands {
namespace {

// Lines "name: value" get their rule as comment. "~" marks fields shown but commented out.
constexpr std::string_view kDischarge =
    R"(# A bucket-elevator discharge (2-D). Check it: granary check FILE. Run it: granary run FILE
discharge {
  particles {
    count: 200
    diameter_min_m: 0.01
    diameter_max_m: 0.012
    density_kg_per_m3: 2200
~   axial_depth_m: 1
  }
  friction_pp_deg: 30
  friction_pw_deg: 20
~ rolling_friction_coefficient: 0.1
~ cohesion_n_per_m: 0
~ normal_restitution: 0
  bucket {
    shape: STRAIGHT  # STRAIGHT, T_TYPE, LOGARITHMIC, BEZIER (x2_m, x3_m, x4_m) or POLYLINE (points)
    tip_x_m: -0.2
    tip_y_m: 0.2
~   wall_height_m: 0.2
~   deflector_m: 0.05
~   deflector_angle_deg: 45
  }
  pulley_radius_m: 0.5
  rotation_rad_per_s: 10.5
~ rademacher_ka: 2
~ time_step_s: 2e-4
}
# effects { gas: OFF }  # each effect AUTO (default), ON or OFF
seed: 1
~ replicates: 4
~ threads: 2
)";

constexpr std::string_view kChute =
    R"(# Flow down an inclined, possibly rotating chute (3-D). Check it: granary check FILE
chute {
  length_m: 0.3
  width_m: 0.08
  depth_m: 0.045
  inclination_deg: 30
  rotation_rpm: 0
  particles {
    diameter_m: 0.003
    density_kg_per_m3: 2550
~   mass_fraction: 1
  }
  contact_pp {
    normal_restitution: 0.97
    tangential_restitution: 0.33
    friction_coefficient: 0.12
~   rolling_friction_coefficient: 0
~   normal_stiffness_n_per_m: 1000
  }
  contact_pw {
    normal_restitution: 0.95
    tangential_restitution: 0.33
    friction_coefficient: 0.22
~   rolling_friction_coefficient: 0
~   normal_stiffness_n_per_m: 1000
  }
  inlet {
    mass_flow_kg_per_s: 0.4
    sluice_height_m: 0.03
  }
  duration_s: 0.4
~ sample_start_s: 0.2
~ time_step_s: 1e-5
}
# effects { gas: OFF }  # each effect AUTO (default), ON or OFF
seed: 1
~ threads: 2
)";

std::string default_text(const FieldRule& rule) {
  switch (rule.presence) {
    case Presence::required:
      return "required";
    case Presence::chosen:
      return "chosen when absent";
    case Presence::optional:
      return "optional";
    case Presence::defaulted:
      break;
  }
  std::ostringstream text;
  text << "default " << rule.fallback;
  return text.str();
}

std::string comment_for(const std::vector<std::string>& blocks, const std::string& field) {
  std::string path;
  for (const std::string& block : blocks)
    path += block + (block == "particles" && blocks.front() == "chute" ? "[]." : ".");
  const FieldRule* rule = find_rule(path + field);
  if (rule == nullptr || std::isinf(rule->maximum)) return "";  // enums explain themselves
  return "  # " + std::string(rule->meaning) + "; " + range_text(*rule) + "; " +
         default_text(*rule);
}

// One line of a template, commented; `blocks` follows the nesting.
std::string commented(std::string line, std::vector<std::string>& blocks) {
  const bool is_off = line.front() == '~';
  if (is_off) line.front() = ' ';
  const auto start = line.find_first_not_of(' ');
  const std::string name = line.substr(start, line.find_first_of(" :", start) - start);
  if (line[start] == '#') return line;
  if (line[start] == '}') {
    blocks.pop_back();
    return line;
  }
  if (line.back() == '{') {
    blocks.push_back(name);
    return line;
  }
  const std::string comment = comment_for(blocks, name);
  return is_off ? line.substr(0, start) + "# " + line.substr(start) + comment : line + comment;
}

std::string scene_template(std::string_view plain) {
  std::istringstream lines{std::string(plain)};
  std::vector<std::string> blocks;
  std::string text;
  for (std::string line; std::getline(lines, line);) text += commented(line, blocks) + "\n";
  return text;
}

}  // namespace

void add_scene(CommandLine& line) {
  auto kind = std::make_shared<std::string>();
  CLI::App& group = line.group("scene", "Write scenes", "granary scene new chute");
  CLI::App& verb = line.verb("new", "Write a commented starting scene",
                             "granary scene new discharge -o bucket.txtpb", &group);
  verb.add_option("KIND", *kind, "discharge or chute")
      ->required()
      ->check(CLI::IsMember({"discharge", "chute"}))
      ->type_name("");
  line.on(verb, [kind](Context& context) -> Outcome {
    const std::string& file = context.options().output;
    if (std::filesystem::exists(file))
      return Error{ErrorCode::failed_precondition, file + " exists already", ""};
    const auto plain = *kind == "chute" ? kChute : kDischarge;
    if (auto written = context.write(scene_template(plain)); !written) return written.error();
    return ExitCode::ok;
  });
}

}  // namespace granary::commands
