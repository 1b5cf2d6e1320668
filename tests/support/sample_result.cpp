#include "tests/support/sample_result.h"

#include <cmath>

namespace granary::testing {
namespace {

using Doubles = std::vector<double>;

core::Column column(const char* name, const char* unit, const Doubles& values) {
  return core::make_column<double>(name, unit, values);
}

storage::Frame sample_frame(std::uint64_t index) {
  const double x = static_cast<double>(index);
  const Doubles position = {x, 2, 3, 4, 5, 6};
  const std::vector<float> radius(3, 0.005f);
  return {index,
          0.25 * x,
          "rotation",
          {core::make_column<double>("position_m", "m", position, 2),
           core::make_column<float>("radius_m", "m", radius)}};
}

}  // namespace

storage::ResultContent sample_content() {
  storage::ResultContent content;
  content.kind = "discharge";
  content.state = "complete";
  content.scene_text = "seed: 7\n";
  content.observation.values = {{"f1_m", "m", 1.92, 0.01, "t-interval"},
                                {"f4_m", "m", {}, {}, "nothing landed"}};
  content.observation.series = {
      {"remaining", {column("time_s", "s", {0, 1}), column("remaining_percent", "%", {100, 40})}}};
  content.observation.fields = {
      {"surface", {column("streamwise_m_per_s", "m/s", {1, std::nan("")})}}};
  content.observation.effect_evaluations = {{"gas", 0}};
  content.replicates = {{7, "aa", {{"f1_m", "m", 1.5, {}, ""}}},
                        {99, "bb", {{"f1_m", "m", 2.5, {}, ""}}}};
  core::EnergyLedger ledger;
  ledger.kinetic_j = 1;
  ledger[core::EnergyChannel::friction] = -2;
  ledger.throughput_j = 2;
  content.ledger = ledger;
  content.effects = {{"gas", false, 0.023, 0.05, {}, "St is large", "auto"}};
  content.provenance = {"1.0",
                        "avx2",
                        "mill",
                        "2026-11-22T05:00:00Z",
                        "key",
                        "hash",
                        2,
                        {{"wall_s", 1.25}},
                        {{"seed", "7", "user", ""}},
                        {"beware"}};
  return content;
}

void write_sample_result(const std::filesystem::path& path) {
  storage::ResultWriter writer(storage::real_file_system(), path);
  for (std::uint64_t i = 0; i < 3; ++i) writer.add_frame(sample_frame(i));
  writer.add_content(sample_content());
  writer.commit();
}

}  // namespace granary::testing
