// granary check: the plan of a scene, without a server: which effects run and why, every setting
// and who chose it.
#include "client/commands/catalogue.h"
#include "client/commands/submission.h"
#include "proto/contract/scene_rules.h"

namespace granary::commands {
namespace {

using render::Json;

constexpr double kPi = 3.14159265358979323846;

// Grains that will ever be in the scene; of a fed chute what its inlet delivers in the whole run.
std::uint64_t particle_count(const v1::Scene& scene) {
  if (scene.has_discharge()) {
    const v1::Discharge& discharge = scene.discharge();
    if (discharge.filling() == v1::Discharge::EXPLICIT)
      return static_cast<std::uint64_t>(discharge.discs_size());
    return discharge.particles().count();
  }
  const v1::Chute& chute = scene.chute();
  double count = chute.initial_count() + chute.beads_size();
  if (chute.inlet().feed() == v1::Inlet::NONE) return static_cast<std::uint64_t>(count);
  const double fed_kg = chute.inlet().mass_flow_kg_per_s() * chute.duration_s();
  for (const auto& grain : chute.particles()) {
    const double mass_kg = grain.density_kg_per_m3() * kPi / 6 * grain.diameter_m() *
                           grain.diameter_m() * grain.diameter_m();
    const double fraction = grain.has_mass_fraction() ? grain.mass_fraction() : 1;
    if (mass_kg > 0) count += fed_kg * fraction / mass_kg;
  }
  return static_cast<std::uint64_t>(count);
}

render::Table effects_table(const ResolvedScene& resolved) {
  render::Table table{
      {"effect", "on", "number", "threshold", "omitted_error", "chosen_by", "reason"}, {}};
  const auto number = [](bool known, double value) {
    return known ? render::number_or_null(value) : Json(nullptr);
  };
  for (const auto& [name, effect] : resolved.effects)
    table.rows.push_back({name, effect.on(), number(effect.has_number(), effect.number()),
                          number(effect.has_threshold(), effect.threshold()),
                          number(effect.has_omitted_error(), effect.omitted_error()),
                          effect.chosen_by(), effect.reason()});
  return table;
}

render::Table settings_table(const ResolvedScene& resolved) {
  render::Table table{{"path", "value", "chosen_by", "evidence"}, {}};
  for (const auto& decision : resolved.decisions)
    table.rows.push_back(
        {decision.path(), decision.value(), decision.chosen_by(), decision.evidence()});
  return table;
}

Json rows_json(const render::Table& table) {
  Json array = Json::array();
  for (std::size_t i = 0; i < table.rows.size(); ++i) array.push_back(render::row_object(table, i));
  return array;
}

Json effects_json(const render::Table& table) {
  Json effects = Json::object();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    Json effect = render::row_object(table, i);
    const std::string name = effect["effect"];
    effect.erase("effect");
    effects[name] = effect;
  }
  return effects;
}

std::string plan_json(const LoadedScene& loaded) {
  const Json plan = {{"scene", loaded.source},
                     {"kind", kind_of(loaded.resolved.scene)},
                     {"key", job_key(loaded.resolved.scene)},
                     {"particles", particle_count(loaded.resolved.scene)},
                     {"effects", effects_json(effects_table(loaded.resolved))},
                     {"settings", rows_json(settings_table(loaded.resolved))},
                     {"warnings", loaded.resolved.warnings}};
  return render::compact(plan) + "\n";
}

std::string plan_text(const LoadedScene& loaded) {
  const auto count = particle_count(loaded.resolved.scene);
  return loaded.source + ": valid " + std::string(kind_of(loaded.resolved.scene)) + ", " +
         std::to_string(count) + " particles\n\n" +
         render::as_aligned_text(effects_table(loaded.resolved)) + "\n" +
         render::as_aligned_text(settings_table(loaded.resolved));
}

Outcome check(Context& context, const SubmissionOptions& options) {
  auto scenes = load_scenes(options);
  if (!scenes) return scenes.error();
  for (const LoadedScene& loaded : *scenes) {
    for (const std::string& warning : loaded.resolved.warnings)
      context.say(loaded.source + ": warning: " + warning);
    const std::string text = context.format() == render::Format::json ? plan_json(loaded)
                             : context.format() == render::Format::csv
                                 ? render::as_csv(settings_table(loaded.resolved))
                                 : plan_text(loaded);
    if (auto written = context.write(text); !written) return written.error();
  }
  return ExitCode::ok;
}

}  // namespace

void add_check(CommandLine& line) {
  auto options = std::make_shared<SubmissionOptions>();
  CLI::App& verb = line.verb("check", "Validate a scene and print its plan; needs no server",
                             "granary check scene.txtpb --set discharge.particles.count=4000");
  add_scene_options(verb, *options, true);
  line.on(verb, [options](Context& context) { return check(context, *options); });
}

}  // namespace granary::commands
