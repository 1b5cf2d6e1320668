#include "proto/contract/scene_rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "proto/contract/discharge_rules.h"
#include "proto/contract/field_path.h"
#include "proto/contract/placement_rules.h"
#include "proto/contract/rule_text.h"

namespace granary {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kNone = 0;
constexpr auto required = Presence::required;
constexpr auto defaulted = Presence::defaulted;
constexpr auto chosen = Presence::chosen;
constexpr auto maybe = Presence::optional;

// path, presence, default, minimum, maximum, minimum excluded, meaning
constexpr FieldRule kRules[] = {
    {"seed", defaulted, 1, 0, 1.8e19, false, "seed of all randomness"},
    {"replicates", defaulted, 1, 1, 1000, false, "independent repetitions with derived seeds"},
    {"threads", defaulted, 1, 1, 256, false, "threads of a chute's engine (a discharge has one); never changes a result"},
    {"accuracy.target", maybe, kNone, 0, 0.5, true, "requested relative error"},
    {"accuracy.budget_s", maybe, kNone, 0, 1e8, true, "CPU seconds it may cost"},
    {"output.frame_interval_s", maybe, kNone, 0, 1e6, false,
     "time between stored frames; 0 = none"},
    {"output.frames", maybe, kNone, 0, 100000, false, "stored frames over the run"},
    {"output.series_interval_s", maybe, kNone, 0, 1e6, true, "time between series samples"},

    {"discharge.particles.count", required, kNone, 1, 2e6, false, "disks dropped into the bucket"},
    {"discharge.particles.diameter_min_m", required, kNone, 0, 1, true, "smallest diameter"},
    {"discharge.particles.diameter_max_m", maybe, kNone, 0, 1, true,
     "largest diameter (uniform between)"},
    {"discharge.particles.density_kg_per_m3", required, kNone, 0, 30000, true,
     "mass per disk area and metre of depth"},
    {"discharge.particles.axial_depth_m", defaulted, 1, 0, 10, true,
     "extent along the pulley axis"},
    {"discharge.bucket.shape", defaulted, 0, -kAny, kAny, false, "outer wall"},
    {"discharge.bucket.x2_m", maybe, kNone, -10, 10, false, "Bezier abscissa at 1/4 of tip_y_m"},
    {"discharge.bucket.x3_m", maybe, kNone, -10, 10, false, "Bezier abscissa at 1/2 of tip_y_m"},
    {"discharge.bucket.x4_m", maybe, kNone, -10, 10, false, "Bezier abscissa at 3/4 of tip_y_m"},
    {"discharge.bucket.tip_x_m", defaulted, -0.4, -10, 0, false, "outer end of the wall"},
    {"discharge.bucket.tip_y_m", defaulted, 0.4, 0, 10, true, "outer end of the wall"},
    {"discharge.bucket.opening_angle_deg", maybe, kNone, 0, 90, true,
     "straight wall against the inner wall; replaces tip_x_m"},
    {"discharge.bucket.wall_height_m", chosen, kNone, 0, 10, true, "inner wall; default tip_y_m"},
    {"discharge.bucket.deflector_m", defaulted, 0, 0, 10, false, "deflector beyond the inner wall"},
    {"discharge.bucket.deflector_angle_deg", defaulted, 0, -90, 90, false,
     "deflector turned outwards"},
    {"discharge.bucket.points[].x_m", required, kNone, -10, 10, false, "point of the outer wall"},
    {"discharge.bucket.points[].y_m", required, kNone, -10, 10, false, "point of the outer wall"},
    {"discharge.friction_pp_deg", required, kNone, 0, 89, false,
     "friction angle inside the material"},
    {"discharge.friction_pw_deg", required, kNone, 0, 89, false,
     "friction angle against the bucket"},
    {"discharge.rolling_friction_coefficient", defaulted, 0, 0, 5, false,
     "rolling resistance / normal force and radius"},
    {"discharge.cohesion_n_per_m", defaulted, 0, 0, 1e6, false,
     "cohesive force per metre of depth"},
    {"discharge.normal_restitution", defaulted, 0, 0, 1, false, "normal restitution of an impact"},
    {"discharge.damping_per_s", defaulted, 0, 0, 1e4, false, "mass-proportional damping"},
    {"discharge.pulley_radius_m", defaulted, 0.5, 0, 20, true, "pulley radius R"},
    {"discharge.run_up_m", defaulted, 0, 0, 100, false, "straight belt travel before the pulley"},
    {"discharge.rotation_rad_per_s", maybe, kNone, 0, 500, false, "rotation rate omega"},
    {"discharge.rademacher_ka", maybe, kNone, 0, 1000, true,
     "omega^2 |cg| / g; replaces rotation_rad_per_s"},
    {"discharge.filling", defaulted, 0, -kAny, kAny, false, "how the bucket is filled"},
    {"discharge.initial_velocity", defaulted, 0, -kAny, kAny, false,
     "velocity of the grains at theta = 0"},
    {"discharge.penalty.stiffness_n_per_m", defaulted, 1e7, 1, 1e13, false,
     "contact penalty K_N = K_T"},
    {"discharge.penalty.growth_factor", defaulted, 1.25, 1, 100, false,
     "OPEN_CLOSE: growth of the penalty"},
    {"discharge.penalty.tolerance", defaulted, 0.01, 0, 1, true,
     "overlap / radius that makes the penalty grow"},
    {"discharge.solver.method", defaulted, 0, -kAny, kAny, false, "contact solver"},
    {"discharge.solver.integrator", defaulted, 0, -kAny, kAny, false, "time integration"},
    {"discharge.solver.tolerance", chosen, kNone, 0, 1, true,
     "relative impulse change that ends the sweeps"},
    {"discharge.solver.max_iterations", defaulted, 500, 1, 1000000, false,
     "sweeps or open-close iterations of a step"},
    {"discharge.solver.linear", defaulted, 0, -kAny, kAny, false, "linear solver of OPEN_CLOSE"},
    {"discharge.time_step_s", chosen, kNone, 0, 0.01, true, "time step of the rotation"},
    {"discharge.filling_time_step_s", chosen, kNone, 0, 0.01, true, "time step of the filling"},
    {"discharge.end_angle_deg", defaulted, 180, 0, 3600, true,
     "rotation at which the measurement ends"},
    {"discharge.target[].x_m", required, kNone, -1000, 1000, false, "discharge opening"},
    {"discharge.target[].y_m", required, kNone, -1000, 1000, false, "discharge opening"},
    {"discharge.discs[].x_m", required, kNone, -1000, 1000, false, "centre"},
    {"discharge.discs[].y_m", required, kNone, -1000, 1000, false, "centre"},
    {"discharge.discs[].diameter_m", required, kNone, 0, 10, true, "diameter"},
    {"discharge.discs[].vx_m_per_s", defaulted, 0, -1000, 1000, false, "velocity"},
    {"discharge.discs[].vy_m_per_s", defaulted, 0, -1000, 1000, false, "velocity"},
    {"discharge.discs[].spin_rad_per_s", defaulted, 0, -1e6, 1e6, false, "spin"},
    {"discharge.walls[].points[].x_m", required, kNone, -1000, 1000, false, "point of a wall"},
    {"discharge.walls[].points[].y_m", required, kNone, -1000, 1000, false, "point of a wall"},
    {"discharge.gravity_m_per_s2", defaulted, 9.81, 0, 1000, false, "gravity, downwards"},
    {"discharge.duration_s", maybe, kNone, 0, 1e5, true, "simulated time; replaces end_angle_deg"},
    {"discharge.filling_stiffness_n_per_m", maybe, kNone, 1, 1e13, false,
     "penalty during filling, if another"},
    {"discharge.air_density_kg_per_m3", defaulted, 1.2, 0, 100, false, "air"},
    {"discharge.air_viscosity_pa_s", defaulted, 1.81e-5, 0, 1, true, "air"},

    {"chute.length_m", defaulted, 0.9, 0, 100, true, "along the flow"},
    {"chute.width_m", defaulted, 0.08, 0, 10, true, "between the side walls"},
    {"chute.depth_m", defaulted, 0.045, 0, 10, true, "from the floor to the open top"},
    {"chute.inclination_deg", required, kNone, 0, 90, false, "of the floor against the horizontal"},
    {"chute.rotation_rpm", defaulted, 0, -10000, 10000, false,
     "> 0 pushes the stream to y = width"},
    {"chute.axis_offset_m", defaulted, 0.165, -100, 100, false,
     "vertical axis cuts the floor here, from the inlet"},
    {"chute.particles[].diameter_m", required, kNone, 0, 1, true, "sphere diameter"},
    {"chute.particles[].density_kg_per_m3", required, kNone, 0, 30000, true, "sphere density"},
    {"chute.particles[].mass_fraction", defaulted, 1, 0, 1, true, "share of the feed"},
    {"chute.contact_pp.normal_stiffness_n_per_m", defaulted, 1000, 1, 1e10, false,
     "spring between grains"},
    {"chute.contact_pp.normal_restitution", required, kNone, 0, 1, false, "e_n between grains"},
    {"chute.contact_pp.tangential_restitution", required, kNone, 0, 1, false, "e_t between grains"},
    {"chute.contact_pp.friction_coefficient", required, kNone, 0, 10, false, "mu between grains"},
    {"chute.contact_pp.rolling_friction_coefficient", defaulted, 0, 0, 10, false,
     "mu_r between grains"},
    {"chute.contact_pw.normal_stiffness_n_per_m", defaulted, 1000, 1, 1e10, false,
     "spring at walls"},
    {"chute.contact_pw.normal_restitution", required, kNone, 0, 1, false, "e_n at walls"},
    {"chute.contact_pw.tangential_restitution", required, kNone, 0, 1, false, "e_t at walls"},
    {"chute.contact_pw.friction_coefficient", required, kNone, 0, 10, false, "mu at walls"},
    {"chute.contact_pw.rolling_friction_coefficient", defaulted, 0, 0, 10, false, "mu_r at walls"},
    {"chute.inlet.feed", defaulted, 0, -kAny, kAny, false, "how grains enter"},
    {"chute.inlet.mass_flow_kg_per_s", maybe, kNone, 0, 1e5, true, "feed"},
    {"chute.inlet.sluice_height_m", maybe, kNone, 0, 10, true, "height of the feed"},
    {"chute.inlet.spin", defaulted, 0, -kAny, kAny, false, "spin of entering grains"},
    {"chute.inlet.jitter", defaulted, 0, 0, 0.5, false, "lattice noise in diameters"},
    {"chute.inlet.hopper_height_m", maybe, kNone, 0, 10, true, "height of the hopper's fill"},
    {"chute.inlet.hopper_opening_m", maybe, kNone, 0, 10, true, "height of the hopper's slot"},
    {"chute.inlet.hopper_length_m", maybe, kNone, 0, 10, true, "hopper, along the chute"},
    {"chute.inlet.hopper_opening_width_m", maybe, kNone, 0, 10, true, "width of the hopper's slot"},
    {"chute.gas.drag_law", defaulted, 0, -kAny, kAny, false, "drag law"},
    {"chute.gas.grid[]", maybe, kNone, 1, 4096, false, "gas cells along x, y, z"},
    {"chute.gas.density_kg_per_m3", defaulted, 1.2, 0, 1000, true, "gas"},
    {"chute.gas.viscosity_pa_s", defaulted, 1.81e-5, 0, 10, true, "gas"},
    {"chute.gas.lid", defaulted, 0, -kAny, kAny, false, "open top"},
    {"chute.gas.time_step_s", maybe, kNone, 0, 0.1, true, "gas step"},
    {"chute.duration_s", required, kNone, 0, 1e5, true, "simulated time"},
    {"chute.sample_start_s", chosen, kNone, 0, 1e5, false, "means are taken from here on"},
    {"chute.sample_interval_s", defaulted, 0.01, 0, 1000, true, "between frames of the means"},
    {"chute.time_step_s", chosen, kNone, 0, 0.01, true, "time step"},
    {"chute.frame", defaulted, 0, -kAny, kAny, false, "frame of reference"},
    {"chute.precision", defaulted, 0, -kAny, kAny, false, "arithmetic"},
    {"chute.damping", defaulted, 0, -kAny, kAny, false, "velocity in the dashpot"},
    {"chute.beads[].x_m", required, kNone, -1000, 1000, false, "centre"},
    {"chute.beads[].y_m", required, kNone, -1000, 1000, false, "centre"},
    {"chute.beads[].z_m", required, kNone, -1000, 1000, false, "centre"},
    {"chute.beads[].particle_class", defaulted, 0, 0, 255, false, "index into particles"},
    {"chute.beads[].vx_m_per_s", defaulted, 0, -1000, 1000, false, "velocity"},
    {"chute.beads[].vy_m_per_s", defaulted, 0, -1000, 1000, false, "velocity"},
    {"chute.beads[].vz_m_per_s", defaulted, 0, -1000, 1000, false, "velocity"},
    {"chute.beads[].spin_x_rad_per_s", defaulted, 0, -1e6, 1e6, false, "spin"},
    {"chute.beads[].spin_y_rad_per_s", defaulted, 0, -1e6, 1e6, false, "spin"},
    {"chute.beads[].spin_z_rad_per_s", defaulted, 0, -1e6, 1e6, false, "spin"},
    {"chute.initial_count", defaulted, 0, 0, 1e8, false, "settled grains at the start"},
    {"chute.planes[].point_m[]", required, kNone, -1000, 1000, false, "point of a plane"},
    {"chute.planes[].normal[]", required, kNone, -1, 1, false, "unit normal into the flow"},
    {"chute.triangles[].vertices_m[]", required, kNone, -1000, 1000, false, "corners"},
    {"chute.meshes[].unit_m", defaulted, 1, 0, 1000, true, "length of one unit of the file"},
    {"chute.meshes[].offset_m[]", maybe, kNone, -1000, 1000, false, "added after scaling"},
    {"chute.gravity_m_per_s2", defaulted, 9.81, 0, 1000, false, "gravity"},
    {"chute.cohesion_bond", defaulted, 0, 0, 1e6, false, "cohesive force / weight"},
};

std::optional<Error> check_value(const std::string& path, const Message& message,
                                 const FieldDescriptor& field, int index) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
    const int value = message.GetReflection()->GetEnumValue(message, &field);
    if (field.enum_type()->FindValueByNumber(value)) return {};
    return refuse(path, "has no option number " + std::to_string(value));
  }
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ||
      field.cpp_type() == FieldDescriptor::CPPTYPE_BOOL)
    return {};
  const FieldRule* rule = find_rule(path_pattern(path));
  const double value = scalar_number(message, field, index);
  const std::string text = scalar_text(message, field, index);
  if (!std::isfinite(value)) {
    return refuse(path, "= " + text + " is not a finite number" +
                            (rule ? ", must be " + range_text(*rule) : ""));
  }
  if (!rule) return {};
  const bool low = rule->open_minimum ? value <= rule->minimum : value < rule->minimum;
  if (low || value > rule->maximum)
    return refuse(path, "= " + text + " is out of range, must be " + range_text(*rule) + " (" +
                            std::string(rule->meaning) + ")");
  return {};
}

std::optional<Error> check_values(const v1::Scene& scene) {
  std::optional<Error> first;
  for_each_set_scalar(scene, [&](const std::string& path, const Message& message,
                                 const FieldDescriptor& field, int index) {
    if (!first) first = check_value(path, message, field, index);
  });
  return first;
}

// Required fields of `message`, and of the list elements that are there.
std::optional<Error> check_required(const Message& message, const std::string& prefix) {
  const auto* descriptor = message.GetDescriptor();
  for (int i = 0; i < descriptor->field_count(); ++i) {
    const FieldDescriptor* field = descriptor->field(i);
    const std::string path = prefix + field->name();
    if (field->is_repeated()) {
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
      for (int k = 0; k < message.GetReflection()->FieldSize(message, field); ++k) {
        const Message& child = message.GetReflection()->GetRepeatedMessage(message, field, k);
        if (auto error = check_required(child, path + "[" + std::to_string(k) + "].")) return error;
      }
      continue;
    }
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      if (field->containing_oneof()) continue;
      const Message& child = message.GetReflection()->GetMessage(message, field);
      if (auto error = check_required(child, path + ".")) return error;
      continue;
    }
    const FieldRule* rule = find_rule(path_pattern(path));
    if (rule && rule->presence == Presence::required &&
        !message.GetReflection()->HasField(message, field))
      return refuse(path, "is missing, must be " + range_text(*rule) + " (" +
                              std::string(rule->meaning) + ")");
  }
  return {};
}

// Filling EXPLICIT brings its own disks: only the density of `particles` is asked for.
std::optional<Error> check_discharge_required(const v1::Discharge& discharge) {
  if (discharge.filling() != v1::Discharge::EXPLICIT)
    return check_required(discharge, "discharge.");
  v1::Discharge filled = discharge;
  if (!filled.particles().has_count()) filled.mutable_particles()->set_count(1);
  if (!filled.particles().has_diameter_min_m()) filled.mutable_particles()->set_diameter_min_m(1);
  return check_required(filled, "discharge.");
}

// ---- rules between fields, chute

std::optional<Error> check_beads(const v1::Chute& chute) {
  std::vector<Placed> bodies;
  for (int k = 0; k < chute.beads_size(); ++k) {
    const v1::Bead& bead = chute.beads(k);
    const auto& particle = chute.particles(static_cast<int>(bead.particle_class()));
    bodies.push_back({{bead.x_m(), bead.y_m(), bead.z_m()}, particle.diameter_m() / 2, k});
  }
  return check_placement("chute.beads", std::move(bodies));
}

std::optional<Error> check_inlet(const v1::Chute& chute, double smallest) {
  const v1::Inlet& inlet = chute.inlet();
  if (inlet.feed() == v1::Inlet::NONE) return {};
  if (chute.beads_size() > 0 && !chute.has_inlet()) return {};
  if (inlet.feed() == v1::Inlet::HOPPER) {
    if (!inlet.has_hopper_height_m())
      return refuse("chute.inlet.hopper_height_m",
                 "is missing, must be > 0 and <= 10 (height of the hopper's fill)");
    if (!inlet.has_hopper_opening_m())
      return refuse("chute.inlet.hopper_opening_m",
                 "is missing, must be > 0 and <= 10 (height of the hopper's slot)");
    return {};
  }
  if (!inlet.has_mass_flow_kg_per_s())
    return refuse("chute.inlet.mass_flow_kg_per_s",
                  "is missing, must be > 0 and <= 100000 (or feed: NONE)");
  if (!inlet.has_sluice_height_m())
    return refuse("chute.inlet.sluice_height_m",
                  "is missing, must be > 0 and <= 10 (height of the feed)");
  if (inlet.sluice_height_m() < smallest)
    return refuse("chute.inlet.sluice_height_m",
                  "= " + number(inlet.sluice_height_m()) +
                      " is out of range, must be >= " + number(smallest) + " (one diameter)");
  return {};
}

std::optional<Error> check_size_ratio(const v1::Chute& chute) {
  double smallest = kAny, largest = 0, fractions = 0;
  for (const auto& particle : chute.particles()) {
    smallest = std::min(smallest, particle.diameter_m());
    largest = std::max(largest, particle.diameter_m());
    fractions += particle.has_mass_fraction() ? particle.mass_fraction() : 1;
  }
  if (largest > 50 * smallest)
    return refuse("chute.particles", "spans a size ratio of 1:" + number(largest / smallest) +
                                         ", must be within 1:50");
  if (chute.particles_size() > 1 && std::abs(fractions - 1) > 1e-6)
    return refuse("chute.particles",
                  "has mass fractions that sum to " + number(fractions) + ", must be 1");
  return check_inlet(chute, largest);
}

std::optional<Error> check_chute(const v1::Chute& chute) {
  if (chute.particles_size() == 0)
    return refuse("chute.particles", "is empty, needs at least one size class");
  for (int i = 0; i < chute.beads_size(); ++i)
    if (static_cast<int>(chute.beads(i).particle_class()) >= chute.particles_size())
      return refuse("chute.beads[" + std::to_string(i) + "].particle_class",
                    "names a class that is not in chute.particles");
  if (auto error = check_beads(chute)) return error;
  for (int i = 0; i < chute.planes_size(); ++i)
    if (chute.planes(i).point_m_size() != 3 || chute.planes(i).normal_size() != 3)
      return refuse("chute.planes[" + std::to_string(i) + "]",
                    "needs 3 numbers in point_m and in normal");
  for (int i = 0; i < chute.triangles_size(); ++i)
    if (chute.triangles(i).vertices_m_size() != 9)
      return refuse("chute.triangles[" + std::to_string(i) + "].vertices_m", "needs 9 numbers");
  for (int i = 0; i < chute.meshes_size(); ++i)
    if (chute.meshes(i).offset_m_size() != 0 && chute.meshes(i).offset_m_size() != 3)
      return refuse("chute.meshes[" + std::to_string(i) + "].offset_m", "needs 3 numbers: x, y, z");
  if (chute.gas().grid_size() != 0 && chute.gas().grid_size() != 3)
    return refuse("chute.gas.grid", "needs 3 numbers: cells along x, y, z");
  if (chute.has_sample_start_s() && chute.sample_start_s() >= chute.duration_s())
    return refuse("chute.sample_start_s",
                  "= " + number(chute.sample_start_s()) +
                      " is out of range, must be < duration_s = " + number(chute.duration_s()));
  return check_size_ratio(chute);
}

}  // namespace

std::span<const FieldRule> scene_rules() {
  return kRules;
}

const FieldRule* find_rule(std::string_view pattern) {
  static const auto by_path = [] {
    std::unordered_map<std::string_view, const FieldRule*> map;
    for (const FieldRule& rule : kRules) map.emplace(rule.path, &rule);
    return map;
  }();
  const auto found = by_path.find(pattern);
  return found == by_path.end() ? nullptr : found->second;
}

std::string range_text(const FieldRule& rule) {
  return (rule.open_minimum ? "> " : ">= ") + number(rule.minimum) +
         " and <= " + number(rule.maximum);
}

std::string_view kind_of(const v1::Scene& scene) {
  switch (scene.kind_case()) {
    case v1::Scene::kDischarge:
      return "discharge";
    case v1::Scene::kChute:
      return "chute";
    default:
      return "";
  }
}

Status validate_scene(const v1::Scene& scene) {
  if (auto error = check_values(scene)) return *error;
  if (scene.has_accuracy() && scene.accuracy().has_target() &&
      scene.accuracy().observable().empty())
    return refuse("accuracy.observable",
                  "is missing: the target needs a key of `values`, e.g. f1_m");
  if (scene.has_discharge()) {
    if (auto error = check_discharge_required(scene.discharge())) return *error;
    if (auto error = check_discharge(scene.discharge())) return *error;
    if (scene.discharge().filling() == v1::Discharge::STORED && scene.replicates() > 1)
      return refuse("replicates",
                    "= " + std::to_string(scene.replicates()) +
                        " is out of range, must be 1 with filling STORED: one filling, "
                        "one run");
    return Done{};
  }
  if (scene.has_chute()) {
    if (auto error = check_required(scene.chute(), "chute.")) return *error;
    if (auto error = check_chute(scene.chute())) return *error;
    return Done{};
  }
  return refuse("kind", "is missing: a scene holds either discharge {...} or chute {...}");
}

}  // namespace granary
