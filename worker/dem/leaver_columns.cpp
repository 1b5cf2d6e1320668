#include "worker/dem/leaver_columns.h"

#include <cstdint>
#include <stdexcept>

namespace granary::dem {
namespace {

constexpr std::size_t kLeaverWidth = 9;  // time, position, velocity, diameter, mass

}  // namespace

void put_leavers(core::State& state, std::span<const Leaver> leavers) {
  std::vector<double> rows;
  std::vector<std::int64_t> ids;
  for (const Leaver& l : leavers) {
    rows.insert(rows.end(), {l.time, l.position.x, l.position.y, l.position.z, l.velocity.x,
                             l.velocity.y, l.velocity.z, l.diameter, l.mass});
    ids.push_back(l.id);
  }
  state.put("dem.leavers", "SI", rows, kLeaverWidth);
  state.put("dem.leaver_id", "1", ids);
}

std::vector<Leaver> get_leavers(const core::State& state) {
  const auto rows = state.get<double>("dem.leavers");
  const auto ids = state.get<std::int64_t>("dem.leaver_id");
  if (rows.size() != ids.size() * kLeaverWidth) throw std::runtime_error("state: leavers");
  std::vector<Leaver> leavers;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const double* r = &rows[k * kLeaverWidth];
    leavers.push_back({r[0], ids[k], {r[1], r[2], r[3]}, {r[4], r[5], r[6]}, r[7], r[8]});
  }
  return leavers;
}

}  // namespace granary::dem
