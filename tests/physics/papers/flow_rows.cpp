// How beds flow out: Figs. 8, 10, 11, 13 and 14, and the onset in full buckets.
#include <algorithm>
#include <cmath>

#include "tests/physics/papers/scoreboard.h"

namespace granary::tests {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kNoBucket = "bucket and resistance to rolling not stated";

// The paper does not say what keeps its disks from rolling, and friction of 47 deg does not: every
// angle is given for disks that roll freely and for disks that do not.
struct Beds {
  std::vector<DischargeRun> rolling, locked;
};

Beds beds_of(const std::string& scene, Settings settings, const Effort& effort) {
  Beds beds{runs_of(scene, settings, effort.fillings), {}};
  settings.emplace_back("effects.particle_rotation", "OFF");
  beds.locked = runs_of(scene, settings, effort.fillings);
  return beds;
}

Verdict judge_both(bool rolling, bool locked) {
  return rolling ? Verdict::agrees : locked ? Verdict::agrees_spin_locked : Verdict::differs;
}

template <typename Function>
Row angle_row(const std::string& claim, const Beds& beds, Function measure, double paper,
              double tolerance, const std::string& note) {
  const Sample rolling = over(beds.rolling, measure), locked = over(beds.locked, measure);
  const auto fits = [&](const Sample& s) { return std::abs(s.mean - paper) <= tolerance; };
  return {claim,
          text(rolling, 0) + " deg rolling, " + text(locked, 0) + " deg locked",
          text(paper, 0) + " deg",
          "-",
          judge_both(fits(rolling), fits(locked)),
          "within " + text(tolerance, 0) + " deg; " + note};
}

auto left(double percent) {
  return [percent](const DischargeRun& run) { return angle_of_percent_left(run, percent); };
}
double centroid_moves(const DischargeRun& run) {
  return run.cg_moves_deg;
}

Sample percent_left(const std::vector<DischargeRun>& runs, double percent) {
  return over(runs, [&](const DischargeRun& run) { return angle_of_percent_left(run, percent); });
}

Sample final_percent(const std::vector<DischargeRun>& runs) {
  return over(runs, [](const DischargeRun& run) { return run.remaining.back(); });
}

// Two buckets hold gravity discharge as long as the paper says: rolling disks under a deflector,
// disks that do not roll in one filled to the brim.
void add_gravity_rows(const Effort& effort, std::vector<Row>& rows) {
  const Beds beds{
      runs_of("discharge_700_gravity_deflector", {}, effort.fillings),
      runs_of("discharge_700_gravity", {{"effects.particle_rotation", "OFF"}}, effort.fillings)};
  const std::string buckets =
      "bucket not stated: rolling in a bucket with a deflector inclined by 45 deg, not full to the "
      "brim; locked in a full one without";
  const Sample rolling = over(beds.rolling, centroid_moves),
               locked = over(beds.locked, centroid_moves);
  rows.push_back({"Fig. 8: the centroid does not move before (by a diameter)",
                  text(rolling, 0) + " deg rolling, " + text(locked, 0) + " deg locked", "90 deg",
                  "-", judge_both(rolling.mean > 80, locked.mean > 80),
                  "not before 80 deg; " + buckets});
  rows.push_back(angle_row("Fig. 9: gravity discharge is held until (5 % left)", beds, left(5), 110,
                           10, buckets));
  const Sample rest = final_percent(beds.rolling);
  rows.push_back({"Fig. 8: complete at the end of the rotation", text(rest, 1) + " % remain", "0 %",
                  "-", judge(rest.mean < 2), "2 %"});
  const Sample lead = over(beds.rolling, [](const DischargeRun& run) {
    const ExitByPlace exits = mean_exit_by_place(run, 0.3);
    return exits.far_from_outer - exits.near_outer;
  });
  rows.push_back({"Fig. 8: disks at the outer wall leave first",
                  "they lead the others by " + text(lead, 1) + " deg", "first", "-",
                  judge(lead.mean > 0), "sign; outer wall = nearest 30 % of the bed"});
}

double exits_begin(const DischargeRun& run, std::uint32_t stratum) {
  std::vector<double> angles;
  for (const DiskHistory& disk : run.disks)
    if (disk.stratum == stratum && !std::isnan(disk.left_deg)) angles.push_back(disk.left_deg);
  if (angles.empty()) return NAN;
  std::sort(angles.begin(), angles.end());
  return angles[angles.size() / 20];
}

void add_centrifugal_rows(const Effort& effort, std::vector<Row>& rows) {
  std::vector<double> onset;
  for (const std::string shape : {"LOGARITHMIC", "STRAIGHT", "T_TYPE"}) {
    const Beds beds =
        beds_of("discharge_700_centrifugal", {{"discharge.bucket.shape", shape}}, effort);
    if (shape == "LOGARITHMIC") {
      rows.push_back(angle_row("Fig. 10: discharge of the logarithmic bucket begins (5 % left)",
                               beds, left(5), 40, 10, kNoBucket));
      rows.push_back(angle_row(
          "Fig. 10: the lowest layer begins to leave", beds,
          [](const DischargeRun& r) { return exits_begin(r, 0); }, 90, 15, kNoBucket));
    }
    onset.push_back(over(beds.rolling, centroid_moves).mean);
    if (shape == "STRAIGHT")
      rows.push_back(angle_row("6: movement begins in a full bucket (centroid moved by a diameter)",
                               beds, centroid_moves, 25, 10,
                               "speed and bucket not stated, ours 8.9 rad/s, straight"));
  }
  const auto [least, most] = std::minmax_element(onset.begin(), onset.end());
  rows.push_back({"6: that angle is the same for any shape (logarithmic, straight, T-type)",
                  text(onset[0], 0) + ", " + text(onset[1], 0) + ", " + text(onset[2], 0) + " deg",
                  "constant", "constant", judge(*most - *least <= 5), "within 5 deg"});
}

void add_rademacher_rows(const Effort& effort, std::vector<Row>& rows) {
  const Beds slow = beds_of("discharge_ka_0_8", {}, effort);
  rows.push_back(
      angle_row("Fig. 13, Ka 0.8: discharge begins (5 % left)", slow, left(5), 100, 10, kNoBucket));
  rows.push_back(angle_row(
      "Fig. 13, Ka 0.8: the bed leaves the outer wall", slow,
      [](const DischargeRun& run) { return run.off_outer_wall_deg; }, 135, 10, kNoBucket));
  rows.push_back(
      angle_row("Fig. 13, Ka 0.8: thrown out (95 % left)", slow, left(95), 165, 15, kNoBucket));
  const Beds fast = beds_of("discharge_ka_0_8", {{"discharge.rademacher_ka", "2"}}, effort);
  const Sample rolling = percent_left(fast.rolling, 5), locked = percent_left(fast.locked, 5);
  rows.push_back({"Fig. 14, Ka 2: first discharge (5 % left)",
                  text(rolling, 0) + " deg rolling, " + text(locked, 0) + " deg locked",
                  "before 90 deg", "before 90 deg", judge_both(rolling.mean < 90, locked.mean < 90),
                  kNoBucket});
  const Sample later = percent_left(slow.rolling, 50), sooner = percent_left(fast.rolling, 50);
  rows.push_back({"Fig. 14: Ka 2 empties at a lower angle than Ka 0.8 (half left)",
                  text(sooner, 0) + " against " + text(later, 0) + " deg", "lower", "lower",
                  judge(sooner.mean < later.mean), "order"});
}

}  // namespace

std::vector<Row> flow_rows(const Effort& effort) {
  std::vector<Row> rows;
  add_gravity_rows(effort, rows);
  add_centrifugal_rows(effort, rows);
  add_rademacher_rows(effort, rows);
  const auto ordered = runs_of("discharge_m_type_ordered", {}, 1);
  rows.push_back(
      {"Fig. 11: beads in compact order, M-type bucket",
       "half left at " + text(percent_left(ordered, 50), 0) + " deg, f1 " +
           text(value_over(ordered, "f1_m"), 2) + " m",
       "inside the experiment's band", "a band in the figure", Verdict::reported,
       "no number stated; bucket, number of beads and radius (0.25 or 0.5 m) not stated"});
  return rows;
}

}  // namespace granary::tests
