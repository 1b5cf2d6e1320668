// The assembled penalty matrix c M + dt^2 K of an open-close iteration, three unknowns (mean
// velocity x, y, surface speed) per disk, and its linear solvers.
//
// The pattern holds every contact of the step, open ones with zeros, so that it is built and
// analysed once per step, however often contacts change state.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/dda/system.h"

namespace granary::dda {

struct BlockPair {
  std::int32_t first = 0;  // rows of blocks
  std::int32_t second = 0;
};

// Direction of one contact component: coefficients on (vx, vy, surface speed) of its two bodies.
struct ContactDirection {
  Eigen::Vector3d first, second;
};

class OpenCloseMatrix {
 public:
  static constexpr std::int32_t kWall = -1;  // a body without unknowns

  // One block per contact between two disks; pairs may come in any order and orientation.
  OpenCloseMatrix(std::size_t block_count, std::span<const BlockPair> contacts,
                  LinearSolver linear);

  void clear(std::span<const Eigen::Vector3d> mass);
  // Adds stiffness * d d^T for the contact with this index.
  void add(std::size_t contact, double stiffness, const ContactDirection& direction);
  // False when the matrix is not positive definite or PCG does not converge. `unknowns`: guess in,
  // solution out.
  bool solve(const Eigen::VectorXd& right, Eigen::VectorXd& unknowns);
  std::uint64_t linear_iterations() const { return linear_iterations_; }

 private:
  void build_pattern(std::size_t block_count);
  bool solve_pcg(const Eigen::VectorXd& right, Eigen::VectorXd& unknowns);

  std::vector<BlockPair> contacts_;
  std::vector<std::int32_t> offset_;  // of a contact's block below the diagonal of its column
  LinearSolver linear_;
  Eigen::SparseMatrix<double> lower_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor_;
  bool analysed_ = false;
  std::uint64_t linear_iterations_ = 0;
};

}  // namespace granary::dda
