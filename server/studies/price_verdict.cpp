#include "server/studies/price_verdict.h"

#include <algorithm>
#include <cstdio>

#include "server/studies/price.h"

namespace granary::server {
namespace {

std::string error_text(double relative) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", relative);
  return text;
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, seconds < 10 ? "%.2g s" : "%.0f s", seconds);
  return text;
}

}  // namespace

std::string finest_clause(const Ladder& ladder, const PriceTrials& trials,
                          const std::string& observable) {
  if (ladder.screening) return "";  // its finest is the base scene
  const std::vector<KnownRung> rungs = trials.known(ladder, observable);
  const auto base = std::find_if(rungs.begin(), rungs.end(),
                                 [](const KnownRung& rung) { return rung.rung->inputs.empty(); });
  if (base == rungs.end() || base + 1 == rungs.end()) return "";
  const KnownRung& finest = rungs.back();
  const Difference off = difference(finest.level, base->level);
  char text[256];
  std::snprintf(text, sizeof text,
                "%s instead of %.6g: %s %+.2g +- %.1g (%s), ledger remainder %.1e instead of "
                "%.1e, %.1f times the CPU",
                rung_name(ladder.path, finest.rung->value).c_str(), base->rung->value,
                observable.c_str(), off.value, off.half_width,
                off.shows() ? "shows" : "below noise", finest.outcome->ledger_remainder_ratio,
                base->outcome->ledger_remainder_ratio,
                finest.outcome->cpu_s / base->outcome->cpu_s);
  return text;
}

std::string target_clause(const PricePlan& plan, const PriceTrials& trials,
                          const std::string& observable) {
  if (!plan.target) return "";
  std::string met, missed;
  for (const Ladder& ladder : plan.ladders) {
    const auto error = base_error(trials, ladder, observable);
    if (ladder.screening || !error) continue;
    std::string& list = error->total <= *plan.target ? met : missed;
    list += (list.empty() ? "" : ", ") + ladder.path + " (" + error_text(error->total);
    if (error->sampling > *plan.target)
      list += ", sampling alone " + error_text(error->sampling) + ": needs more replicates";
    list += ")";
  }
  if (met.empty() && missed.empty()) return "";
  char text[64];
  std::snprintf(text, sizeof text, "target = %.6g of ", *plan.target);
  std::string clause = text + observable + ": ";
  if (!met.empty()) clause += "met in " + met;
  if (!missed.empty()) clause += (met.empty() ? "not met in " : ", not in ") + missed;
  return clause;
}

std::string budget_clause(const PricePlan& plan, const PriceTrials& trials,
                          const std::vector<LeftOut>& left_out) {
  if (left_out.empty()) return "";
  char text[64];
  std::snprintf(text, sizeof text, "budget_s = %.6g left out ", *plan.budget_s);
  std::string clause = text;
  for (const LeftOut& each : left_out)
    clause += (&each == &left_out.front() ? "" : ", ") +
              rung_name(each.trial.ladder->path, each.trial.rung->value) + ", which needs about " +
              seconds_text(each.cpu_s);
  return clause + " (spent: " + seconds_text(spent_s(trials)) + ")";
}

std::string failure_clause(const PricePlan& plan, const PriceTrials& trials) {
  if (!climbs_in_rounds(plan) || trials.outcomes().size() == 0 || trials.base()) return "";
  return "the base scene failed: nothing finer was tried";
}

}  // namespace granary::server
