// What accuracy costs and what effects contribute, through real programs: price, ablate and a scene
// that asks for an accuracy.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Accuracy : public RealService {
 protected:
  std::string answer(const std::vector<std::string>& arguments) {
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    return outputs.out;
  }
  json rows(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--format", "json"});
    return json::parse(answer(arguments));
  }
  std::vector<std::string> small_bucket(const std::string& verb) const {
    return {verb, scene("discharge_small"), "--set", "discharge.particles.count=60"};
  }
  // Half a second of CPU for three replicates.
  std::vector<std::string> short_chute(const std::string& verb) const {
    return {verb,    scene("chute_small"),    "--set", "effects.gas=AUTO",
            "--set", "chute.rotation_rpm=16", "--set", "chute.length_m=0.15",
            "--set", "chute.duration_s=0.25", "--set", "chute.sample_start_s=0.15",
            "--set", "accuracy.target=0.01",  "--set", "accuracy.observable=exit_speed_m_per_s"};
  }
};

json row_of(const json& rows, const std::string& effect) {
  for (const json& row : rows)
    if (row["effect"] == effect) return row;
  return {};
}

// More than `share` of the observable, beyond the interval of what was measured.
bool exceeds(const json& row, double share) {
  return std::abs(row["relative"].get<double>()) - row["relative_error"].get<double>() > share;
}

TEST_F(Accuracy, price_prints_every_rung_and_stores_it_in_its_view) {
  start_worker(2);
  const std::string plot = scratch.file("price.svg");
  auto arguments = small_bucket("price");
  arguments.insert(arguments.end(), {"--observable", "f1_m", "--ladder", "discharge.time_step_s",
                                     "--rungs", "3", "--replicates", "2", "-o", plot});
  const json table = rows(arguments);
  const json stored = rows({"query", "SELECT rung, value, error, cpu_s, job FROM price"});
  ASSERT_EQ(table.size(), stored.size());
  int steps = 0, knees = 0;
  for (std::size_t k = 0; k < table.size(); ++k) {
    EXPECT_EQ(table[k]["value"], stored[k]["value"]);
    EXPECT_EQ(table[k]["error"], stored[k]["error"]);
    EXPECT_GT(table[k]["cpu_s"].get<double>(), 0);
    if (table[k]["setting"] != "discharge.time_step_s") continue;
    ++steps;
    knees += table[k]["knee"].get<bool>() ? 1 : 0;
    EXPECT_GT(table[k]["memory_bytes"].get<double>(), 1e6);
    EXPECT_LT(table[k]["ledger_remainder"].get<double>(), 1e-3);
    EXPECT_EQ(state(table[k]["job"]), "complete");
  }
  EXPECT_EQ(steps, 3);
  EXPECT_EQ(knees, 1);
  std::stringstream svg;
  svg << std::ifstream(plot).rdbuf();
  EXPECT_EQ(svg.str().rfind("<svg", 0), 0u);
  EXPECT_THAT(svg.str(), HasSubstr("discharge_small"));
  EXPECT_THAT(svg.str(), testing::Not(HasSubstr(scene("discharge_small")))) << "a path in a title";
}

TEST_F(Accuracy, price_names_what_its_budget_leaves_out) {
  start_worker(2);
  auto arguments = small_bucket("price");
  arguments.insert(arguments.end(),
                   {"--observable", "f1_m", "--ladder", "discharge.time_step_s", "--rungs", "3",
                    "--replicates", "2", "--budget", "0.001s", "--format", "json"});
  const Outputs outputs = granary(arguments);
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_THAT(outputs.err, HasSubstr("budget_s = 0.001 left out discharge.time_step_s=0.0001"));
  const json table = json::parse(outputs.out);
  int steps = 0;
  for (const json& row : table) {
    if (row["setting"] != "discharge.time_step_s") continue;
    ++steps;
    EXPECT_GE(row["rung"].get<double>(), 2e-4);
  }
  EXPECT_EQ(steps, 2);
  arguments.insert(arguments.end(), {"--target", "2"});
  const Outputs refused = granary(arguments);
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, HasSubstr("price.target: = 2 is out of range, must be > 0 and < 1"));
}

// What AUTO decides at 1 % against what the ablation measures, at 16 rpm; the whole comparison is
// tests/accuracy/ablate.sh.
TEST_F(Accuracy, auto_decides_as_the_ablation_measures) {
  start_worker(2);
  auto arguments = short_chute("ablate");
  arguments.insert(arguments.end(), {"--replicates", "3", "--observable", "exit_speed_m_per_s"});
  const std::string wall = "chute.contact_pw.friction_coefficient=0.11";
  const std::string restitution = "chute.contact_pp.tangential_restitution=0.9";
  for (const std::string& effect :
       {std::string("gas"), std::string("rotating_frame"), std::string("rolling_friction"),
        std::string("cohesion"), wall, restitution})
    arguments.insert(arguments.end(), {"--effect", effect});
  const json table = rows(arguments);
  const json decided = rows(short_chute("check"))["effects"];
  EXPECT_TRUE(decided["rotating_frame"]["on"].get<bool>());
  EXPECT_TRUE(exceeds(row_of(table, "rotating_frame"), 0.01));
  for (const char* effect : {"rolling_friction", "cohesion"}) {
    EXPECT_FALSE(decided[effect]["on"].get<bool>()) << effect;
    EXPECT_FALSE(exceeds(row_of(table, effect), decided[effect]["omitted_error"].get<double>()))
        << effect;
  }
  EXPECT_FALSE(decided["gas"]["on"].get<bool>());
  EXPECT_THAT(row_of(table, "gas")["verdict"].get<std::string>(), HasSubstr("not available"));
  EXPECT_TRUE(exceeds(row_of(table, wall), 0.05)) << "wall friction is strong";
  EXPECT_FALSE(exceeds(row_of(table, restitution), 0)) << "e_t is nil";
  const json stored =
      rows({"query", "SELECT effect, observable, delta, error, cpu_ratio FROM effects"});
  ASSERT_EQ(stored.size() + 1, table.size()) << "all but the gas";
  for (const json& row : stored)
    EXPECT_EQ(row["delta"], row_of(table, row["effect"])["delta"]) << row;
}

TEST_F(Accuracy, a_scene_that_asks_for_an_accuracy_gets_every_part_of_its_error) {
  start_worker(2);
  auto arguments = small_bucket("submit");
  arguments.insert(arguments.end(), {"--set", "accuracy.target=0.2", "--set",
                                     "accuracy.observable=f1_m", "--wait", "--format", "json"});
  const json done = json::parse(answer(arguments));
  EXPECT_EQ(done["state"], "complete");
  const json f1 = done["values"]["f1_m"];
  EXPECT_LE(f1["error"].get<double>(), 0.21 * std::abs(f1["value"].get<double>()));
  const std::string basis = f1["error_basis"];
  for (const char* part : {"discretisation", "stiffness", "solver", "sampling"})
    EXPECT_THAT(basis, HasSubstr(part));
  const std::string explained = answer({"explain", done["job"]});
  EXPECT_THAT(explained, HasSubstr("expected error of f1_m"));
  // The same request is the same result; nothing is piloted twice.
  EXPECT_EQ(json::parse(answer(arguments))["state_hash"], done["state_hash"]);
  EXPECT_EQ(rows({"query", "SELECT count(*) AS n FROM tasks"})[0]["n"], 1);
}

}  // namespace
}  // namespace granary::test
