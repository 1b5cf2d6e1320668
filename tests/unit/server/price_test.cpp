#include "server/studies/price.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "proto/contract/field_path.h"
#include "proto/contract/scene_text.h"
#include "server/studies/ablate.h"

namespace granary::server {
namespace {

v1::StudySpec spec_of(const std::string& scene_text) {
  v1::StudySpec spec;
  auto scene = load_scene(scene_text, "scene.txtpb", {});
  EXPECT_TRUE(scene) << scene.error().message;
  *spec.mutable_scene() = *scene;
  return spec;
}

const char* kDischarge =
    "discharge { particles { count: 50 diameter_min_m: 0.004 density_kg_per_m3: 730 } "
    "friction_pp_deg: 30 friction_pw_deg: 20 rotation_rad_per_s: 9 }";
const char* kChute =
    "chute { inclination_deg: 30 duration_s: 1 particles { diameter_m: 0.003 density_kg_per_m3: "
    "2550 } contact_pp { normal_restitution: 0.9 tangential_restitution: 0.3 friction_coefficient: "
    "0.3 } contact_pw { normal_restitution: 0.9 tangential_restitution: 0.3 friction_coefficient: "
    "0.3 } inlet { feed: NONE } initial_count: 10 }";

constexpr const char* kDiscSize = "discharge.particles.diameter_min_m";

// f1 = 2 (1 + 100 dt), exactly first order in the time step, with a little noise.
TrialOutcome run(const TrialProposal& proposal) {
  TrialOutcome outcome;
  outcome.state = v1::COMPLETE;
  outcome.job = "jobs/1";
  double dt = 2e-4;
  if (const auto found = proposal.inputs.find("discharge.time_step_s");
      found != proposal.inputs.end())
    dt = std::stod(found->second);
  v1::Quantity& f1 = (*outcome.result.mutable_values())["f1_m"];
  f1.set_value(2 * (1 + 100 * dt));
  f1.set_error(1e-5);
  outcome.result.mutable_cost()->set_cpu_s(1e-4 / dt);
  outcome.result.mutable_cost()->set_peak_rss_bytes(5e7);
  outcome.result.mutable_ledger()->set_remainder_ratio(dt);
  return outcome;
}

std::vector<TrialProposal> run_all(StudyGenerator& study) {
  std::vector<TrialProposal> all;
  for (std::uint32_t told = 0; !study.done();)
    for (TrialProposal& proposal : study.ask(3)) {
      study.tell(++told, run(proposal));
      all.push_back(std::move(proposal));
    }
  return all;
}

TEST(Price, climbs_step_penalty_tolerance_and_size_around_the_base_scene) {
  auto study = make_price(spec_of(kDischarge));
  ASSERT_TRUE(study) << study.error().message;
  const auto trials = run_all(**study);
  EXPECT_EQ(trials.size(), (*study)->planned());
  EXPECT_EQ(trials[0].role, "base");
  std::map<std::string, int> rungs;
  for (const TrialProposal& trial : trials) {
    EXPECT_EQ(trial.scene.replicates(), 4u);
    EXPECT_FALSE(trial.scene.has_accuracy());
    for (const auto& [path, value] : trial.inputs) ++rungs[path];
  }
  // Four of its own, two of coarser disks, whose step follows.
  EXPECT_EQ(rungs["discharge.time_step_s"], 6);
  EXPECT_EQ(rungs["discharge.filling_time_step_s"], 6);
  EXPECT_EQ(rungs["discharge.particles.diameter_min_m"], 2);
  EXPECT_EQ(rungs["discharge.penalty.stiffness_n_per_m"], 3);
  EXPECT_EQ(rungs["discharge.solver.tolerance"], 3);
}

TEST(Price, finds_the_order_the_limit_and_the_knee) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_NEAR(summary.figures().at("order|discharge.time_step_s|f1_m").value(), 1, 0.01);
  EXPECT_NEAR(summary.figures().at("limit|discharge.time_step_s|f1_m").value(), 2, 1e-4);
  EXPECT_EQ(summary.figures().at("order|discharge.solver.tolerance|f1_m").error_basis(),
            "below noise");
  // The error still falls with the step: the finest one is the knee. The penalty does nothing.
  EXPECT_NEAR(summary.figures().at("knee|discharge.time_step_s").value(), 5e-5, 1e-9);
  EXPECT_NE(summary.verdict().find("discharge.time_step_s=5e-05"), std::string::npos)
      << summary.verdict();
}

TEST(Price, says_what_the_finest_rung_bought_beyond_the_base_scene) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_NEAR(summary.figures().at("remainder|discharge.time_step_s=5e-05").value(), 5e-5, 1e-12);
  EXPECT_NE(summary.verdict().find("discharge.time_step_s=5e-05 instead of 0.0002: f1_m -0.03"),
            std::string::npos)
      << summary.verdict();
  EXPECT_NE(summary.verdict().find("(shows), ledger remainder 5.0e-05 instead of 2.0e-04, 4.0 "
                                   "times the CPU"),
            std::string::npos)
      << summary.verdict();
  EXPECT_NE(summary.verdict().find("discharge.penalty.stiffness_n_per_m=1e+08 instead of 1e+07: "
                                   "f1_m +0 +- 1e-05 (below noise)"),
            std::string::npos)
      << summary.verdict();
}

TEST(Price, stores_every_rung_with_its_error_and_price) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  std::map<std::string, PricePoint> points;
  const auto findings = (*study)->findings();
  for (const PricePoint& point : findings->price) points[point.rung] = point;
  const PricePoint& coarsest = points.at("discharge.time_step_s=0.0008");
  EXPECT_EQ(coarsest.observable, "f1_m");
  EXPECT_NEAR(*coarsest.error, 0.16, 1e-3);
  EXPECT_NEAR(*coarsest.cpu_s, 0.125, 1e-9);
  EXPECT_TRUE(points.contains("replicates=8"));
  EXPECT_NEAR(*points.at("replicates=8").error / *points.at("replicates=2").error, 0.5, 1e-9);
}

TEST(Price, goes_on_after_a_restart_where_it_was) {
  auto whole = make_price(spec_of(kDischarge));
  auto first = make_price(spec_of(kDischarge));
  auto second = make_price(spec_of(kDischarge));
  run_all(**whole);
  const auto begun = (*first)->ask(2);
  (*first)->tell(1, run(begun[0]));
  (*second)->restore((*first)->save());
  (*second)->tell(2, run(begun[1]));
  for (std::uint32_t told = 2; !(*second)->done();)
    for (const TrialProposal& proposal : (*second)->ask(5)) (*second)->tell(++told, run(proposal));
  EXPECT_EQ((*second)->save(), (*whole)->save());
  EXPECT_THROW((*second)->restore("nonsense"), std::exception);
}

TEST(Price, scales_both_stiffnesses_of_a_chute_and_its_step_with_them) {
  auto study = make_price(spec_of(kChute));
  ASSERT_TRUE(study) << study.error().message;
  bool found = false;
  for (const TrialProposal& trial : (*study)->ask(100)) {
    const auto pp = trial.inputs.find("chute.contact_pp.normal_stiffness_n_per_m");
    if (pp == trial.inputs.end() || std::stod(pp->second) != 4000) continue;
    found = true;
    EXPECT_EQ(trial.inputs.at("chute.contact_pw.normal_stiffness_n_per_m"), "4000");
    EXPECT_TRUE(trial.inputs.contains("chute.time_step_s"));
  }
  EXPECT_TRUE(found);
}

TEST(Price, refuses_ladders_that_the_scene_does_not_have) {
  v1::StudySpec spec = spec_of(kChute);
  spec.mutable_price()->add_ladder("chute.nonsense");
  const auto study = make_price(spec);
  ASSERT_FALSE(study);
  EXPECT_EQ(study.error().field_path, "price.ladder");
  EXPECT_NE(study.error().message.find("chute.time_step_s"), std::string::npos);
  v1::StudySpec single = spec_of(kChute);
  single.mutable_price()->set_replicates(1);
  EXPECT_EQ(make_price(single).error().field_path, "price.replicates");
}

// ---- size, for screening

// The rungs of one ladder by the label of their setting.
std::map<std::string, std::map<std::string, std::string>> inputs_of(StudyGenerator& study,
                                                                    const std::string& path) {
  std::map<std::string, std::map<std::string, std::string>> rungs;
  for (const TrialProposal& trial : study.ask(100))
    if (const auto found = trial.inputs.find(path); found != trial.inputs.end())
      rungs[found->second] = trial.inputs;
  return rungs;
}

TEST(Price, coarser_disks_keep_their_solid_area_and_their_collisions_as_many_steps) {
  v1::StudySpec spec = spec_of(kDischarge);
  auto& particles = *spec.mutable_scene()->mutable_discharge()->mutable_particles();
  particles.set_count(52);
  particles.set_diameter_max_m(0.005);
  spec.mutable_scene()->mutable_discharge()->set_filling_time_step_s(4e-4);
  auto study = make_price(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto rungs = inputs_of(**study, kDiscSize);
  ASSERT_EQ(rungs.size(), 2u);  // the base scene is the finest
  const std::map<std::string, std::string> twice = {{kDiscSize, "0.008"},
                                                    {"discharge.particles.diameter_max_m", "0.01"},
                                                    {"discharge.particles.count", "13"},
                                                    {"discharge.time_step_s", "0.0004"},
                                                    {"discharge.filling_time_step_s", "0.0008"}};
  EXPECT_EQ(rungs.at("0.008"), twice);
  EXPECT_EQ(rungs.at("0.00565685").at("discharge.particles.count"), "26");
}

TEST(Price, coarser_grains_of_a_chute_take_every_class_along_and_the_contact_time) {
  v1::StudySpec spec = spec_of(kChute);
  v1::Chute& chute = *spec.mutable_scene()->mutable_chute();
  chute.set_time_step_s(1e-5);
  chute.set_initial_count(80);
  chute.mutable_particles(0)->set_mass_fraction(0.5);
  *chute.add_particles() = chute.particles(0);
  chute.mutable_particles(1)->set_diameter_m(0.002);
  auto study = make_price(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto rungs = inputs_of(**study, "chute.particles[0].diameter_m");
  ASSERT_EQ(rungs.size(), 2u);
  const std::map<std::string, std::string> twice = {{"chute.particles[0].diameter_m", "0.006"},
                                                    {"chute.particles[1].diameter_m", "0.004"},
                                                    {"chute.initial_count", "10"},
                                                    {"chute.time_step_s", "2.82843e-05"}};
  EXPECT_EQ(rungs.at("0.006"), twice);
}

TEST(Price, has_no_ladder_of_sizes_for_particles_placed_by_hand) {
  v1::StudySpec discs = spec_of(
      "discharge { filling: EXPLICIT no_bucket: true duration_s: 0.1 friction_pp_deg: 30 "
      "friction_pw_deg: 20 particles { count: 1 diameter_min_m: 0.01 density_kg_per_m3: 730 } "
      "discs { x_m: 0 y_m: 0 diameter_m: 0.01 } }");
  v1::StudySpec beads = spec_of(kChute);
  beads.mutable_scene()->mutable_chute()->clear_initial_count();
  v1::Bead& bead = *beads.mutable_scene()->mutable_chute()->add_beads();
  bead.set_x_m(0.1);
  bead.set_y_m(0.04);
  bead.set_z_m(0.01);
  for (const v1::StudySpec& spec : {discs, beads}) {
    auto study = make_price(spec);
    ASSERT_TRUE(study) << study.error().message;
    for (const TrialProposal& trial : (*study)->ask(100))
      for (const auto& [path, value] : trial.inputs)
        EXPECT_EQ(path.find("diameter"), std::string::npos) << path;
  }
}

TEST(Price, screening_is_measured_against_the_base_scene_and_has_no_order) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  const auto summary = (*study)->summary();
  const std::string path = kDiscSize;
  const v1::Quantity& order = summary.figures().at("order|" + path + "|f1_m");
  EXPECT_FALSE(order.has_value()) << "f1 is exactly first order in the step that follows";
  EXPECT_EQ(order.error_basis(), "screening");
  EXPECT_NEAR(summary.figures().at("limit|" + path + "|f1_m").value(), 2.04, 1e-12);
  EXPECT_EQ(summary.figures().at("bias|" + path + "=0.004|f1_m").value(), 0);
  EXPECT_NEAR(summary.figures().at("bias|" + path + "=0.008|f1_m").value(), 0.04, 1e-9);
  EXPECT_NEAR(summary.figures().at("knee|" + path).value(), 0.004, 1e-12);
  EXPECT_EQ(summary.verdict().find(path + "=0.004 instead of"), std::string::npos);
  std::map<std::string, PricePoint> points;
  const auto findings = (*study)->findings();
  for (const PricePoint& point : findings->price) points[point.rung] = point;
  EXPECT_NEAR(*points.at(path + "=0.004").error, 1e-5, 1e-12) << "sampling alone";
  EXPECT_NEAR(*points.at(path + "=0.008").error, 0.04, 1e-5);
}

TEST(Price, screening_says_nothing_when_the_base_scene_has_failed) {
  auto study = make_price(spec_of(kDischarge));
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : (*study)->ask(100))
    (*study)->tell(++told, proposal.role == "base" ? TrialOutcome{} : run(proposal));
  EXPECT_FALSE((*study)->summary().figures().contains(std::string("knee|") + kDiscSize));
  EXPECT_TRUE((*study)->summary().figures().contains("knee|discharge.time_step_s"));
}

// ---- budget and target

std::set<std::string> labels_of(const std::vector<TrialProposal>& trials) {
  std::set<std::string> labels;
  for (const TrialProposal& trial : trials) labels.insert(trial.label);
  return labels;
}

// The finer steps take 1 s and 2 s, the tenfold penalty sqrt(10) x 0.5 s by prediction, a tolerance
// 0.5 s; the base scene and all that is coarser 2.98 s.
TEST(Price, a_budget_leaves_out_the_finest_and_says_so) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_budget_s(6);
  auto study = make_price(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto trials = run_all(**study);
  const auto labels = labels_of(trials);
  EXPECT_TRUE(labels.contains("time_step_s=0.0001"));
  EXPECT_FALSE(labels.contains("time_step_s=5e-05"));
  EXPECT_TRUE(labels.contains("stiffness_n_per_m=1e+08"));
  EXPECT_TRUE(labels.contains("tolerance=0.0333333"));
  EXPECT_EQ(trials.size(), (*study)->planned());
  EXPECT_NE(
      (*study)->summary().verdict().find("budget_s = 6 left out "
                                         "discharge.time_step_s=5e-05, which needs about 2 s"),
      std::string::npos)
      << (*study)->summary().verdict();
  double spent_s = 0;
  for (const TrialProposal& trial : trials) spent_s += run(trial).result.cost().cpu_s();
  EXPECT_LE(spent_s, 6);
}

TEST(Price, a_budget_for_everything_leaves_nothing_out) {
  v1::StudySpec spec = spec_of(kDischarge);
  auto plain = make_price(spec);
  spec.mutable_price()->set_budget_s(1e6);
  auto within = make_price(spec);
  EXPECT_EQ(labels_of(run_all(**within)), labels_of(run_all(**plain)));
  EXPECT_EQ((*within)->summary().verdict(), (*plain)->summary().verdict());
}

TEST(Price, a_failed_rung_is_charged_at_its_prediction) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->add_ladder("discharge.time_step_s");
  const auto climbs_on = [&spec](double budget_s) {
    spec.mutable_price()->set_budget_s(budget_s);
    auto study = make_price(spec);
    bool finest = false;
    for (std::uint32_t told = 0; !(*study)->done();)
      for (const TrialProposal& proposal : (*study)->ask(100)) {
        finest = finest || proposal.label == "time_step_s=5e-05";
        const bool fails = proposal.label == "time_step_s=0.0001";
        (*study)->tell(++told, fails ? TrialOutcome{} : run(proposal));
      }
    return finest;
  };
  // 0.875 s for the base scene and the coarser ones, 1 s for the failed one, 2 s for the next.
  EXPECT_TRUE(climbs_on(3.9));
  EXPECT_FALSE(climbs_on(3.8));
}

TEST(Price, a_target_stops_the_climb_of_the_ladders_that_meet_it) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_target(0.01);  // the step's error is 0.04 of 2.04, the others' none
  auto study = make_price(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto labels = labels_of(run_all(**study));
  EXPECT_TRUE(labels.contains("time_step_s=5e-05"));
  EXPECT_TRUE(labels.contains("stiffness_n_per_m=1e+06"));
  EXPECT_FALSE(labels.contains("stiffness_n_per_m=1e+08"));
  EXPECT_FALSE(labels.contains("tolerance=0.1"));
  const std::string verdict = (*study)->summary().verdict();
  EXPECT_NE(verdict.find("target = 0.01 of f1_m: met in discharge.penalty.stiffness_n_per_m "
                         "(4.9e-06), discharge.solver.tolerance (4.9e-06), not in "
                         "discharge.time_step_s (0.02)"),
            std::string::npos)
      << verdict;
  spec.mutable_price()->set_target(0.05);
  auto easy = make_price(spec);
  EXPECT_FALSE(labels_of(run_all(**easy)).contains("time_step_s=0.0001"));
  EXPECT_EQ((*easy)->summary().verdict().find("not in"), std::string::npos);
}

// Without an order, what is still to come may be as large as the last difference that shows.
TEST(Price, one_visible_difference_without_an_order_meets_no_target) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_target(0.01);
  spec.mutable_price()->add_ladder("discharge.time_step_s");
  spec.mutable_price()->set_rungs(4);  // one coarser, two finer
  auto study = make_price(spec);
  EXPECT_TRUE(labels_of(run_all(**study)).contains("time_step_s=0.0001"));
}

TEST(Price, asks_for_a_finer_rung_only_when_all_of_its_round_are_told) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_budget_s(1e6);
  auto study = make_price(spec);
  const auto first = (*study)->ask(100);
  EXPECT_EQ(first.size(), 8u);  // base, 2 steps, 2 penalties, 1 tolerance, 2 sizes
  for (std::uint32_t told = 0; told < first.size(); ++told) {
    EXPECT_TRUE((*study)->ask(100).empty());
    EXPECT_FALSE((*study)->done());
    (*study)->tell(told + 1, run(first[told]));
  }
  EXPECT_EQ((*study)->ask(100).size(), 3u);
}

TEST(Price, climbs_nothing_on_a_base_scene_that_has_failed) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_budget_s(1e6);
  auto study = make_price(spec);
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : (*study)->ask(100))
    (*study)->tell(++told, proposal.role == "base" ? TrialOutcome{} : run(proposal));
  EXPECT_TRUE((*study)->done());
  EXPECT_NE((*study)->summary().verdict().find("the base scene failed"), std::string::npos);
}

TEST(Price, goes_on_after_a_restart_in_the_middle_of_its_rounds) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_price()->set_budget_s(6);
  spec.mutable_price()->set_target(0.01);
  auto whole = make_price(spec);
  const auto all = run_all(**whole);
  for (std::size_t stop = 0; stop <= all.size(); ++stop) {
    auto study = make_price(spec);
    std::vector<TrialProposal> trials;
    std::uint32_t told = 0;
    const auto step = [&] {  // up to three run at a time
      for (TrialProposal& proposal : (*study)->ask(3 + told - trials.size()))
        trials.push_back(std::move(proposal));
      (*study)->tell(told + 1, run(trials[told]));
      ++told;
    };
    while (told < stop) step();
    auto again = make_price(spec);
    (*again)->restore((*study)->save());
    EXPECT_EQ((*again)->summary().verdict(), (*study)->summary().verdict());
    EXPECT_EQ((*again)->planned(), (*study)->planned());
    study = std::move(again);
    while (!(*study)->done() || told < trials.size()) step();
    EXPECT_EQ((*study)->save(), (*whole)->save()) << "stopped after " << stop;
  }
  auto other = make_price(spec_of(kChute));
  EXPECT_THROW((*other)->restore("100\n"), std::exception);
}

TEST(Price, refuses_a_bad_budget_or_target_in_one_line) {
  const auto refused = [](auto set) {
    v1::StudySpec spec = spec_of(kDischarge);
    set(*spec.mutable_price());
    const auto study = make_price(spec);
    return study ? std::string("accepted") : study.error().message;
  };
  EXPECT_EQ(refused([](v1::Price& price) { price.set_budget_s(0); }),
            "price.budget_s: = 0 is out of range, must be > 0 and <= 1e+08 (CPU seconds)");
  EXPECT_EQ(refused([](v1::Price& price) { price.set_budget_s(std::nan("")); }),
            "price.budget_s: = nan is out of range, must be > 0 and <= 1e+08 (CPU seconds)");
  for (const double target : {0.0, -0.1, 1.0})
    EXPECT_NE(refused([&](v1::Price& price) {
                price.set_target(target);
              }).find(" is out of range, must be > 0 and < 1 (relative error)"),
              std::string::npos)
        << target;
}

// ---- ablate

TrialOutcome run_pair(const TrialProposal& proposal) {
  TrialOutcome outcome = run(proposal);
  outcome.result.clear_values();
  v1::Quantity& speed = (*outcome.result.mutable_values())["exit_speed_m_per_s"];
  const bool turned_off = proposal.inputs.contains("effects.particle_rotation");
  const bool smooth = proposal.inputs.contains("chute.contact_pp.friction_coefficient");
  speed.set_value(turned_off ? 2.0 : smooth ? 3.5 : 2.5);
  speed.set_error(0.01);
  outcome.result.mutable_cost()->set_cpu_s(turned_off ? 1 : 2);
  return outcome;
}

TEST(Ablate, gives_difference_interval_and_price_of_each_effect) {
  v1::StudySpec spec = spec_of(kChute);
  spec.mutable_ablate()->add_effect("particle_rotation");
  spec.mutable_ablate()->add_effect("chute.contact_pp.friction_coefficient=0");
  auto study = make_ablate(spec);
  ASSERT_TRUE(study) << study.error().message;
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : (*study)->ask(10)) {
    EXPECT_EQ(proposal.scene.replicates(), 6u);
    (*study)->tell(++told, run_pair(proposal));
  }
  EXPECT_EQ(told, 3u);
  const auto rows = (*study)->findings()->effects;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].effect, "particle_rotation");
  EXPECT_NEAR(*rows[0].delta, 0.5, 1e-12);  // with minus without
  EXPECT_GT(*rows[0].error, 0.01);
  EXPECT_LT(*rows[0].error, 0.02);
  EXPECT_NEAR(*rows[0].cpu_ratio, 2, 1e-12);
  EXPECT_NEAR(*rows[1].delta, 1, 1e-12);  // its value minus the scene's
  EXPECT_EQ((*study)->summary().figures().at("on|particle_rotation").value(), 1);
  EXPECT_NEAR(
      (*study)->summary().figures().at("relative|particle_rotation|exit_speed_m_per_s").value(),
      0.2, 1e-12);
}

TEST(Ablate, a_changed_setting_brings_the_effect_that_it_calls_for) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_ablate()->add_effect("discharge.rolling_friction_coefficient=0.1");
  auto study = make_ablate(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto trials = (*study)->ask(10);
  ASSERT_EQ(trials.size(), 2u);
  EXPECT_EQ(trials[0].scene.effects().rolling_friction(), v1::Effects::OFF);
  EXPECT_NE(trials[1].scene.effects().rolling_friction(), v1::Effects::OFF);
}

TEST(Ablate, without_a_list_tries_every_effect_and_says_what_is_not_available) {
  auto study = make_ablate(spec_of(kChute));
  ASSERT_TRUE(study);
  const auto trials = (*study)->ask(100);
  EXPECT_EQ((*study)->planned(), trials.size());
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_TRUE(summary.figures().contains("unavailable|gas"));
  EXPECT_NE(summary.figures().at("unavailable|gas").error_basis().find("not available"),
            std::string::npos);
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : trials) (*study)->tell(++told, run_pair(proposal));
  auto again = make_ablate(spec_of(kChute));
  (*again)->restore((*study)->save());
  EXPECT_EQ((*again)->save(), (*study)->save());
  EXPECT_EQ((*again)->findings()->effects.size(), (*study)->findings()->effects.size());
}

TEST(Ablate, refuses_unknown_effects_and_bad_settings) {
  for (const char* effect : {"magic", "chute.contact_pp.friction_coefficient=-1", "nonsense=1"}) {
    v1::StudySpec spec = spec_of(kChute);
    spec.mutable_ablate()->add_effect(effect);
    EXPECT_FALSE(make_ablate(spec)) << effect;
  }
}

}  // namespace
}  // namespace granary::server
