#include "worker/dda/open_close.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/dda/narrow_phase.h"
#include "worker/dda/open_close_matrix.h"

namespace granary::dda {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Of the way from a threshold to mu P_n per update: taken whole, the fixed point diverges where
// mu > 1 meets a wedge.
constexpr double kThresholdShare = 0.7;
constexpr int kSearchSteps = 12;  // halvings of the interval along a Newton step

struct Components {
  double n = 0, t = 0;
};

struct PenaltyContact {
  BlockPair bodies;
  ContactDirection normal, tangent;
  double bias_n, bias_t, friction;
  double threshold;  // of the tangential impulse [N s]
  Components now;    // relative velocity
  Components ahead;  // its change along the Newton step
};

class OpenCloseStep {
 public:
  explicit OpenCloseStep(System& system);
  void iterate();
  bool settled();
  void write_back();

 private:
  void gather(const ActiveContacts& list, double friction);
  Components components(const PenaltyContact& c, const VectorXd& velocity) const;
  Components forces(const PenaltyContact& c, const Components& u) const;
  void push(VectorXd& vector, const BlockPair& bodies, const ContactDirection& d,
            double impulse) const;
  void assemble();
  void add_forces(VectorXd& momentum) const;
  double slope(const VectorXd& direction, double share) const;
  double best_share(const VectorXd& direction) const;
  bool balanced() const;
  bool update_thresholds();

  System& system_;
  double stiffness_;  // K dt^2 [kg]
  bool spins_;
  std::vector<std::int32_t> block_of_;  // per disk, kWall = not touched
  std::vector<std::size_t> disk_of_;
  std::vector<Vector3d> mass_;
  std::vector<PenaltyContact> contacts_;
  std::optional<OpenCloseMatrix> matrix_;
  VectorXd masses_, loaded_, velocity_;  // loaded = velocities without contact forces
};

OpenCloseStep::OpenCloseStep(System& system) : system_(system) {
  const ContactTerms terms = pair_terms(system);
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
  const auto size = static_cast<Eigen::Index>(3 * disk_of_.size());
  masses_.resize(size), loaded_.resize(size), velocity_.resize(size);
  for (std::size_t b = 0; b < disk_of_.size(); ++b) {
    const auto row = static_cast<Eigen::Index>(3 * b);
    const DiskMotion& v = system.disks.motion[disk_of_[b]];
    const DiskMotion& old = system.motion_before[disk_of_[b]];
    masses_.segment<3>(row) = mass_[b];
    loaded_.segment<3>(row) = Vector3d{v.vx, v.vy, v.surface_speed};
    // The velocities at the start of the step leave the contacts as they are.
    velocity_.segment<3>(row) = Vector3d{old.vx, old.vy, old.surface_speed};
  }
  gather(system.pair_contacts, system.contact.friction_disks);
  gather(system.wall_contacts, system.contact.friction_walls);
  std::vector<BlockPair> pairs;
  for (const PenaltyContact& c : contacts_) pairs.push_back(c.bodies);
  matrix_.emplace(disk_of_.size(), pairs, system.solver.linear);
}

void OpenCloseStep::gather(const ActiveContacts& list, double friction) {
  const double turn = spins_ ? -1 : 0;
  for (std::size_t k = 0; k < list.size; ++k) {
    if (list.slot[k] < 0) continue;
    const double nx = list.normal_x[k], ny = list.normal_y[k];
    const auto first = static_cast<std::size_t>(list.first[k]);
    const auto second = static_cast<std::size_t>(list.second[k]);
    const double locked = spins_ ? 0
                                 : system_.disks.motion[first].surface_speed +
                                       system_.disks.motion[second].surface_speed;
    PenaltyContact c{{block_of_[first], block_of_[second]},
                     {{-nx, -ny, 0}, {nx, ny, 0}},
                     {{ny, -nx, turn}, {-ny, nx, turn}},
                     list.bias_n[k],
                     list.bias_t[k] - locked,
                     friction,
                     friction * std::max(list.impulse_n[k], 0.0),
                     {},
                     {}};
    c.now = components(c, velocity_);
    contacts_.push_back(c);
  }
}

Components OpenCloseStep::components(const PenaltyContact& c, const VectorXd& velocity) const {
  Components u;
  if (c.bodies.first != OpenCloseMatrix::kWall) {
    const Vector3d v = velocity.segment<3>(3 * c.bodies.first);
    u = {c.normal.first.dot(v), c.tangent.first.dot(v)};
  }
  if (c.bodies.second != OpenCloseMatrix::kWall) {
    const Vector3d v = velocity.segment<3>(3 * c.bodies.second);
    u.n += c.normal.second.dot(v);
    u.t += c.tangent.second.dot(v);
  }
  return u;
}

// Impulses at relative velocity u: the state of the contact is in which branch they fall.
Components OpenCloseStep::forces(const PenaltyContact& c, const Components& u) const {
  return {std::max(-stiffness_ * (u.n + c.bias_n), 0.0),
          std::clamp(-stiffness_ * (u.t + c.bias_t), -c.threshold, c.threshold)};
}

void OpenCloseStep::push(VectorXd& vector, const BlockPair& bodies, const ContactDirection& d,
                         double impulse) const {
  if (bodies.first != OpenCloseMatrix::kWall)
    vector.segment<3>(3 * bodies.first) += impulse * d.first;
  if (bodies.second != OpenCloseMatrix::kWall)
    vector.segment<3>(3 * bodies.second) += impulse * d.second;
}

void OpenCloseStep::assemble() {
  matrix_->clear(mass_);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const PenaltyContact& c = contacts_[k];
    const Components p = forces(c, c.now);
    if (p.n > 0) matrix_->add(k, stiffness_, c.normal);
    if (std::abs(p.t) < c.threshold) matrix_->add(k, stiffness_, c.tangent);
  }
}

void OpenCloseStep::add_forces(VectorXd& momentum) const {
  for (const PenaltyContact& c : contacts_) {
    const Components p = forces(c, c.now);
    push(momentum, c.bodies, c.normal, p.n);
    push(momentum, c.bodies, c.tangent, p.t);
  }
}

// Derivative of the energy along `direction` after `share` of it.
double OpenCloseStep::slope(const VectorXd& direction, double share) const {
  double sum = (velocity_ + share * direction - loaded_).cwiseProduct(masses_).dot(direction);
  for (const PenaltyContact& c : contacts_) {
    const Components p = forces(c, {c.now.n + share * c.ahead.n, c.now.t + share * c.ahead.t});
    sum -= p.n * c.ahead.n + p.t * c.ahead.t;
  }
  return sum;
}

// The slope rises along the step (the energy is convex); a whole step is taken when it does not end
// far beyond the minimum.
double OpenCloseStep::best_share(const VectorXd& direction) const {
  const double start = slope(direction, 0);
  double low = 0, high = 1;
  if (slope(direction, 1) <= 0.1 * std::abs(start)) return 1;
  for (int k = 0; k < kSearchSteps; ++k) {
    const double middle = 0.5 * (low + high);
    (slope(direction, middle) > 0 ? high : low) = middle;
  }
  return high;
}

void OpenCloseStep::iterate() {
  assemble();
  VectorXd momentum = masses_.cwiseProduct(loaded_ - velocity_);
  add_forces(momentum);
  VectorXd direction = VectorXd::Zero(momentum.size());
  if (!matrix_->solve(momentum, direction)) return;
  for (PenaltyContact& c : contacts_) c.ahead = components(c, direction);
  const double share = best_share(direction);
  velocity_ += share * direction;
  for (PenaltyContact& c : contacts_) {
    c.now.n += share * c.ahead.n;
    c.now.t += share * c.ahead.t;
  }
}

// Unbalanced momentum against the momentum that contacts and loads exchange, both over root mass.
bool OpenCloseStep::balanced() const {
  const VectorXd inertia = masses_.cwiseProduct(loaded_ - velocity_);
  VectorXd pushed = VectorXd::Zero(inertia.size());
  add_forces(pushed);
  double total = 0;
  for (const PenaltyContact& c : contacts_) {
    const Components p = forces(c, c.now);
    total += p.n * p.n + p.t * p.t;
  }
  const double tolerance = system_.solver.tolerance;
  return (inertia + pushed).squaredNorm() <= tolerance * tolerance * total;
}

bool OpenCloseStep::update_thresholds() {
  double wrong = 0, total = 0;
  for (PenaltyContact& c : contacts_) {
    const Components p = forces(c, c.now);
    const double limit = c.friction * p.n;
    const double should = std::clamp(-stiffness_ * (c.now.t + c.bias_t), -limit, limit);
    wrong += (p.t - should) * (p.t - should);
    total += p.n * p.n + should * should;
  }
  const double tolerance = system_.solver.tolerance;
  if (wrong <= tolerance * tolerance * total) return true;
  for (PenaltyContact& c : contacts_)
    c.threshold += kThresholdShare * (c.friction * forces(c, c.now).n - c.threshold);
  return false;
}

bool OpenCloseStep::settled() {
  return balanced() && update_thresholds();
}

void OpenCloseStep::write_back() {
  for (std::size_t b = 0; b < disk_of_.size(); ++b) {
    DiskMotion& v = system_.disks.motion[disk_of_[b]];
    const Vector3d velocity = velocity_.segment<3>(static_cast<Eigen::Index>(3 * b));
    v.vx = velocity[0];
    v.vy = velocity[1];
    v.surface_speed = velocity[2];
  }
  auto next = contacts_.begin();
  for (ActiveContacts* list : {&system_.pair_contacts, &system_.wall_contacts})
    for (std::size_t k = 0; k < list->size; ++k) {
      if (list->slot[k] < 0) continue;
      const Components p = forces(*next, next->now);
      list->impulse_n[k] = p.n;
      list->impulse_t[k] = p.t;
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
      open_close.iterate();
      settled = open_close.settled();
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
