#include "proto/contract/resolve.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "proto/contract/chute_rules.h"
#include "proto/contract/contact_effects.h"
#include "proto/contract/effects.h"
#include "proto/contract/field_path.h"
#include "proto/contract/scene_rules.h"
#include "proto/contract/sha256.h"
#include "proto/contract/version.h"

namespace granary {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr double kPi = 3.14159265358979323846;

// Corners by the thousand say nothing to a reader of settings.
constexpr std::string_view kMeshPath = "chute.triangles[";

class Resolver {
 public:
  explicit Resolver(const v1::Scene& scene) { out_.scene = scene; }

  Result<ResolvedScene> run() {
    for_each_set_scalar(out_.scene, [&](const std::string& path, const Message& message,
                                        const FieldDescriptor& field, int index) {
      if (!path.starts_with(kMeshPath)) note(path, scalar_text(message, field, index), "user", "");
    });
    if (const int triangles = out_.scene.chute().triangles_size(); triangles > 0)
      note("chute.triangles", std::to_string(triangles) + " triangles", "user", "");
    if (out_.scene.has_discharge()) choose_discharge(*out_.scene.mutable_discharge());
    fill_defaults(out_.scene, "");
    if (out_.scene.has_chute()) {
      choose_chute(*out_.scene.mutable_chute());
      if (auto error = check_resolved_chute(out_.scene.chute())) return *error;
    }
    if (Status status = decide(); !status) return status.error();
    return std::move(out_);
  }

 private:
  void note(const std::string& path, const std::string& value, const char* who,
            const std::string& why) {
    v1::Decision decision;
    decision.set_path(path);
    decision.set_value(value);
    decision.set_chosen_by(who);
    decision.set_evidence(why);
    out_.decisions.push_back(std::move(decision));
  }

  // Precondition: the path exists. The value is printed with all its digits and read back.
  void choose(const std::string& path, double value, const std::string& why) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    (void)set_field(out_.scene, path, text);
    std::snprintf(text, sizeof text, "%.12g", value);
    note(path, text, "auto", why);
  }

  void fill_defaults(Message& message, const std::string& prefix) {
    const auto* descriptor = message.GetDescriptor();
    const auto* reflection = message.GetReflection();
    for (int i = 0; i < descriptor->field_count(); ++i) {
      const FieldDescriptor* field = descriptor->field(i);
      const std::string path = prefix + field->name();
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        if (field->is_repeated()) {
          for (int k = 0; k < reflection->FieldSize(message, field); ++k)
            fill_defaults(*reflection->MutableRepeatedMessage(&message, field, k),
                          path + "[" + std::to_string(k) + "].");
        } else if (!field->real_containing_oneof() || reflection->HasField(message, field)) {
          if (wanted_group(path))
            fill_defaults(*reflection->MutableMessage(&message, field), path + ".");
        }
        continue;
      }
      if (field->is_repeated() || reflection->HasField(message, field)) continue;
      const FieldRule* rule = find_rule(path_pattern(path));
      if (rule && rule->presence == Presence::defaulted)
        fill(message, *field, path, rule->fallback);
    }
  }

  // Groups whose absence means something are not made by filling in defaults.
  static bool wanted_group(const std::string& path) {
    return path != "accuracy" && path != "output" && path != "effects";
  }

  void fill(Message& message, const FieldDescriptor& field, const std::string& path, double value) {
    const auto* reflection = message.GetReflection();
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        reflection->SetDouble(&message, &field, value);
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        reflection->SetUInt32(&message, &field, static_cast<std::uint32_t>(value));
        break;
      case FieldDescriptor::CPPTYPE_UINT64:
        reflection->SetUInt64(&message, &field, static_cast<std::uint64_t>(value));
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        reflection->SetEnumValue(&message, &field, static_cast<int>(value));
        break;
      default:
        return;
    }
    // Lists of placed grains would drown the settings that somebody wants to read.
    if (path.find('[') == std::string::npos)
      note(path, scalar_text(message, field, -1), "default", "");
  }

  // ---- discharge

  void choose_discharge(v1::Discharge& d) {
    if (d.particles().has_diameter_min_m() && !d.particles().has_diameter_max_m())
      choose("discharge.particles.diameter_max_m", d.particles().diameter_min_m(),
             "one size: diameter_min_m");
    const double tip_y = d.bucket().has_tip_y_m() ? d.bucket().tip_y_m()
                                                  : find_rule("discharge.bucket.tip_y_m")->fallback;
    if (!d.bucket().has_wall_height_m())
      choose("discharge.bucket.wall_height_m", tip_y, "as high as the outer wall (tip_y_m)");
    if (d.bucket().has_opening_angle_deg() && !d.bucket().has_tip_x_m())
      choose("discharge.bucket.tip_x_m",
             -tip_y * std::tan(d.bucket().opening_angle_deg() * kPi / 180),
             "opening_angle_deg and tip_y_m");
    choose_discharge_numerics(d);
    choose_discharge_warnings(d);
  }

  void choose_discharge_numerics(v1::Discharge& d) {
    const double radius = d.has_pulley_radius_m() ? d.pulley_radius_m() : 0.5;
    const double gravity = d.has_gravity_m_per_s2() ? d.gravity_m_per_s2() : 9.81;
    const double froude = d.has_rademacher_ka() ? d.rademacher_ka()
                                                : d.rotation_rad_per_s() * d.rotation_rad_per_s() *
                                                      radius / std::max(gravity, 1e-9);
    const bool small_steps = d.solver().method() == v1::Solver::IMPULSE &&
                             d.solver().integrator() == v1::Solver::BACKWARD_EULER;
    if (!d.solver().has_tolerance() && small_steps)
      choose("discharge.solver.tolerance", 0.3,
             "small steps with K h^2 / m <= 1, each started from the impulses of the one before");
    else if (!d.solver().has_tolerance())
      choose("discharge.solver.tolerance", froude > 1 ? 1e-2 : 1e-3,
             froude > 1 ? "centrifugal flow (omega^2 R / g > 1)" : "gravity discharge and holding");
    if (d.solver().method() == v1::Solver::OPEN_CLOSE && !d.solver().has_max_iterations())
      choose("discharge.solver.max_iterations", 30,
             "open-close: packs that still change states then never stop");
    if (!d.has_time_step_s()) choose("discharge.time_step_s", 2e-4, "default ladder rung");
    if (!d.has_filling_time_step_s())
      choose("discharge.filling_time_step_s", d.time_step_s(), "as time_step_s");
  }

  void choose_discharge_warnings(const v1::Discharge& d) {
    if (d.friction_pp_deg() > 30 && d.rolling_friction_coefficient() == 0)
      out_.warnings.push_back(
          "friction_pp_deg > 30 with rolling_friction_coefficient 0: freely rolling "
          "disks do not build the repose angle a bulk friction angle suggests");
  }

  // ---- chute

  // Contact time [s] of a linear spring-dashpot, PHYSICS A1.
  static double contact_time(double mass, const v1::Contact& contact) {
    const double e = std::max(contact.normal_restitution(), 1e-3);
    const double log_e = std::log(e);
    return std::sqrt(mass * (kPi * kPi + log_e * log_e) / contact.normal_stiffness_n_per_m());
  }

  void choose_chute(v1::Chute& c) {
    double shortest = 1e9;
    for (const auto& particle : c.particles()) {
      const double mass =
          particle.density_kg_per_m3() * kPi / 6 * std::pow(particle.diameter_m(), 3);
      shortest = std::min(
          {shortest, contact_time(mass / 2, c.contact_pp()), contact_time(mass, c.contact_pw())});
    }
    if (!c.has_time_step_s()) {
      const double step = shortest / 42;
      const double unit = std::pow(10.0, std::floor(std::log10(step)) - 1);
      choose("chute.time_step_s", std::floor(step / unit) * unit,
             "t_c/42 of the shortest contact: bulk flow as at t_c/170");
    } else if (c.time_step_s() > shortest / 5) {
      limit_ = shortest / 5;
    }
    if (c.inlet().feed() == v1::Inlet::HOPPER && !c.inlet().has_hopper_length_m())
      choose("chute.inlet.hopper_length_m", c.inlet().hopper_height_m(), "as long as it is high");
    if (!c.has_sample_start_s())
      choose("chute.sample_start_s", c.duration_s() / 3, "a third of the duration");
  }

  // ---- effects

  Status decide() {
    if (limit_ > 0) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "chute.time_step_s: = %.6g is out of range, must be > 0 and <= %.6g (a fifth "
                    "of the shortest contact)",
                    out_.scene.chute().time_step_s(), limit_);
      return Error{ErrorCode::invalid_argument, text, "chute.time_step_s"};
    }
    out_.effects = decide_effects(out_.scene);
    v1::Effects& effects = *out_.scene.mutable_effects();
    if (effects.gas() == v1::Effects::ON && out_.scene.has_chute())
      return Error{ErrorCode::invalid_argument,
                   "effects.gas: = ON is not available in this version, must be AUTO or OFF",
                   "effects.gas"};
    for (const auto& [name, report] : out_.effects) {
      const auto* field = effects.GetDescriptor()->FindFieldByName(name);
      if (field == nullptr) continue;  // an omission that is only reported
      effects.GetReflection()->SetEnumValue(&effects, field,
                                            report.on() ? v1::Effects::ON : v1::Effects::OFF);
      if (report.chosen_by() == "auto")
        note("effects." + name, report.on() ? "ON" : "OFF", "auto", report.reason());
    }
    if (out_.scene.has_discharge()) return check_contact_effects(out_.scene);
    return Done{};
  }

  ResolvedScene out_;
  double limit_ = 0;
};

std::string canonical_text(const v1::Scene& scene, const std::set<std::string>& without) {
  std::string text = std::string("engine=") + kEngineVersion + "\n";
  for_each_set_scalar(scene, [&](const std::string& path, const Message& message,
                                 const FieldDescriptor& field, int index) {
    for (const std::string& prefix : without)
      if (path == prefix || path.rfind(prefix + ".", 0) == 0 || path.rfind(prefix + "[", 0) == 0)
        return;
    text += path + "=" + scalar_text(message, field, index) + "\n";
  });
  return text;
}

}  // namespace

Result<ResolvedScene> resolve(const v1::Scene& scene) {
  if (Status status = validate_scene(scene); !status) return status.error();
  return Resolver(scene).run();
}

std::string job_key(const v1::Scene& resolved) {
  return sha256_hex(canonical_text(resolved, {"name", "threads", "output"}));
}

std::string filling_key(const v1::Scene& resolved) {
  const auto how = resolved.discharge().filling();
  if (!resolved.has_discharge() ||
      (how != v1::Discharge::DROP && how != v1::Discharge::ORDERED_COMPACT))
    return "";
  static const std::set<std::string> kRotationOnly = {"name",
                                                      "threads",
                                                      "output",
                                                      "accuracy",
                                                      "replicates",
                                                      "discharge.rotation_rad_per_s",
                                                      "discharge.rademacher_ka",
                                                      "discharge.initial_velocity",
                                                      "discharge.run_up_m",
                                                      "discharge.end_angle_deg",
                                                      "discharge.target",
                                                      "discharge.time_step_s",
                                                      "discharge.duration_s",
                                                      "discharge.solver",
                                                      "discharge.penalty.growth_factor",
                                                      "discharge.penalty.tolerance",
                                                      "discharge.pulley_radius_m",
                                                      "discharge.air_density_kg_per_m3",
                                                      "discharge.air_viscosity_pa_s",
                                                      "effects.gas"};
  return sha256_hex("filling\n" + canonical_text(resolved, kRotationOnly));
}

}  // namespace granary
