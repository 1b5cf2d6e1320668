#include "worker/dda/open_close.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/dda/narrow_phase.h"
#include "worker/dda/open_close_matrix.h"

namespace granary::dda {
namespace {

using Eigen::Vector3d;

enum class ContactState : std::uint8_t { open, stick, slide_forward, slide_back };

struct PenaltyContact {
  BlockPair bodies;
  ContactDirection normal, tangent;
  double bias_n, bias_t, friction;
  double impulse_n, impulse_t;  // of the last iteration
  ContactState state;
};

ContactState judged(double impulse_n, double trial_t, double friction) {
  if (impulse_n <= 0) return ContactState::open;
  if (friction == 0) return ContactState::slide_forward;  // of no force: either direction
  if (trial_t > friction * impulse_n) return ContactState::slide_forward;
  if (trial_t < -friction * impulse_n) return ContactState::slide_back;
  return ContactState::stick;
}

// The states of the last step are inherited through the forces it left.
ContactState inherited(const ActiveContacts& contacts, std::size_t k, double friction) {
  constexpr double kOnLimit = 1 - 1e-9;
  const double impulse_n = contacts.impulse_n[k], impulse_t = contacts.impulse_t[k];
  if (impulse_n > 0 && friction > 0 && std::abs(impulse_t) >= kOnLimit * friction * impulse_n)
    return impulse_t > 0 ? ContactState::slide_forward : ContactState::slide_back;
  if (impulse_n > 0 || contacts.gap_start[k] < 0)
    return friction > 0 ? ContactState::stick : ContactState::slide_forward;
  return ContactState::open;
}

class OpenCloseStep {
 public:
  explicit OpenCloseStep(System& system);
  bool iterate();  // true once no contact contradicts its state
  void write_back();

 private:
  void gather(ActiveContacts& list, double friction);
  void assemble();
  bool judge();
  double component(const PenaltyContact& c, const ContactDirection& d) const;

  System& system_;
  double stiffness_;    // K dt^2 [kg]
  bool spins_;
  std::vector<std::int32_t> block_of_;  // per disk, kWall = not touched
  std::vector<std::size_t> disk_of_;
  std::vector<Vector3d> mass_;
  std::vector<PenaltyContact> contacts_;
  std::vector<BlockPair> pairs_;
  std::optional<OpenCloseMatrix> matrix_;
  Eigen::VectorXd loads_, right_, unknowns_;
};

OpenCloseStep::OpenCloseStep(System& system) : system_(system) {
  const ContactTerms terms = contact_terms(system, 0);
  stiffness_ = 1 / terms.compliance;
  spins_ = terms.spin_factor > 0;
  block_of_.assign(system.disks.count() + 1, OpenCloseMatrix::kWall);
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (!system.touched[k]) continue;
    block_of_[k] = static_cast<std::int32_t>(disk_of_.size());
    disk_of_.push_back(k);
    const double mass = 1 / system.disks.motion[k].inverse_mass;
    mass_.emplace_back(mass, mass, spins_ ? mass / terms.spin_factor : mass);
  }
  gather(system.pair_contacts, system.contact.friction_disks);
  gather(system.wall_contacts, system.contact.friction_walls);
  for (const PenaltyContact& c : contacts_) pairs_.push_back(c.bodies);
  matrix_.emplace(disk_of_.size(), pairs_, system.solver.linear);

  const auto size = static_cast<Eigen::Index>(3 * disk_of_.size());
  unknowns_.resize(size);
  loads_.resize(size);
  for (std::size_t b = 0; b < disk_of_.size(); ++b) {
    const DiskMotion& v = system.disks.motion[disk_of_[b]];
    const Vector3d velocity{v.vx, v.vy, v.surface_speed};
    unknowns_.segment<3>(static_cast<Eigen::Index>(3 * b)) = velocity;
    loads_.segment<3>(static_cast<Eigen::Index>(3 * b)) = mass_[b].cwiseProduct(velocity);
  }
}

void OpenCloseStep::gather(ActiveContacts& list, double friction) {
  for (std::size_t k = 0; k < list.size; ++k) {
    if (list.slot[k] < 0) continue;
    const double nx = list.normal_x[k], ny = list.normal_y[k];
    const double turn = spins_ ? -1 : 0;
    const auto first = static_cast<std::size_t>(list.first[k]);
    const auto second = static_cast<std::size_t>(list.second[k]);
    const double locked = spins_ ? 0
                                 : system_.disks.motion[first].surface_speed +
                                       system_.disks.motion[second].surface_speed;
    contacts_.push_back({{block_of_[first], block_of_[second]},
                         {{-nx, -ny, 0}, {nx, ny, 0}},
                         {{ny, -nx, turn}, {-ny, nx, turn}},
                         list.bias_n[k],
                         list.bias_t[k] - locked,
                         friction,
                         list.impulse_n[k],
                         list.impulse_t[k],
                         inherited(list, k, friction)});
  }
}

double OpenCloseStep::component(const PenaltyContact& c, const ContactDirection& d) const {
  double sum = 0;
  if (c.bodies.first != OpenCloseMatrix::kWall)
    sum += d.first.dot(unknowns_.segment<3>(3 * c.bodies.first));
  if (c.bodies.second != OpenCloseMatrix::kWall)
    sum += d.second.dot(unknowns_.segment<3>(3 * c.bodies.second));
  return sum;
}

void OpenCloseStep::assemble() {
  matrix_->clear(mass_);
  right_ = loads_;
  const auto push = [&](const PenaltyContact& c, const ContactDirection& d, double impulse) {
    if (c.bodies.first != OpenCloseMatrix::kWall)
      right_.segment<3>(3 * c.bodies.first) += impulse * d.first;
    if (c.bodies.second != OpenCloseMatrix::kWall)
      right_.segment<3>(3 * c.bodies.second) += impulse * d.second;
  };
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const PenaltyContact& c = contacts_[k];
    if (c.state == ContactState::open) continue;
    matrix_->add(k, stiffness_, c.normal);
    push(c, c.normal, -stiffness_ * c.bias_n);
    if (c.state == ContactState::stick) {
      matrix_->add(k, stiffness_, c.tangent);
      push(c, c.tangent, -stiffness_ * c.bias_t);
    } else {
      push(c, c.tangent, c.impulse_t);
    }
  }
}

bool OpenCloseStep::judge() {
  std::size_t changed = 0;
  double change = 0, total = 0;
  for (PenaltyContact& c : contacts_) {
    const double impulse_n = -stiffness_ * (component(c, c.normal) + c.bias_n);
    const double trial_t = -stiffness_ * (component(c, c.tangent) + c.bias_t);
    const ContactState next = judged(impulse_n, trial_t, c.friction);
    if (next != c.state) ++changed;
    c.state = next;
    c.impulse_n = std::max(impulse_n, 0.0);
    const double limit = c.friction * c.impulse_n;
    const double impulse_t = std::clamp(trial_t, -limit, limit);
    if (next != ContactState::stick) change += std::pow(impulse_t - c.impulse_t, 2);
    c.impulse_t = impulse_t;
    total += c.impulse_n * c.impulse_n + impulse_t * impulse_t;
  }
  const double tolerance = system_.solver.tolerance;
  return changed == 0 && change <= tolerance * tolerance * total;
}

bool OpenCloseStep::iterate() {
  assemble();
  const bool solved = matrix_->solve(right_, unknowns_);
  const bool settled = judge();
  return solved && settled;
}

void OpenCloseStep::write_back() {
  for (std::size_t b = 0; b < disk_of_.size(); ++b) {
    DiskMotion& v = system_.disks.motion[disk_of_[b]];
    const Vector3d velocity = unknowns_.segment<3>(static_cast<Eigen::Index>(3 * b));
    v.vx = velocity[0];
    v.vy = velocity[1];
    v.surface_speed = velocity[2];
  }
  auto next = contacts_.begin();
  for (ActiveContacts* list : {&system_.pair_contacts, &system_.wall_contacts})
    for (std::size_t k = 0; k < list->size; ++k) {
      if (list->slot[k] < 0) continue;
      list->impulse_n[k] = next->impulse_n;
      list->impulse_t[k] = next->impulse_t;
      ++next;
    }
  system_.counters.linear_iterations += matrix_->linear_iterations();
}

}  // namespace

void solve_open_close(System& system) {
  std::uint32_t iterations = 0;
  bool settled = true;
  if (system.report.contacts > 0) {
    OpenCloseStep open_close(system);
    do {
      settled = open_close.iterate();
      ++iterations;
    } while (!settled && iterations < system.solver.max_sweeps);
    open_close.write_back();
  }
  system.report.sweeps = iterations;
  system.report.converged = settled;
  system.counters.open_close_iterations += iterations;
  if (!settled) ++system.counters.unconverged_steps;
}

}  // namespace granary::dda
