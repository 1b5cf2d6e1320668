// What the kernels look up: contact coefficients by kind, walls, and the coefficients of the kick.
#pragma once

#include "worker/dem/kernels.h"
#include "worker/dem/setup.h"

namespace granary::dem {

struct Laws {
  LawTables pairs;  // kind = class_a * classes + class_b
  LawTables walls;  // kind = class_a
};

// Throws std::invalid_argument when there are more classes or walls than the tables hold.
Laws law_tables(const EngineSetup& setup);
WallTables wall_tables(const std::vector<Plane>& walls);

// The kick of BodyTerms (Crank-Nicolson rotation) written as v += N dt with N linear in force,
// position and velocity.
BodyCoefficients body_coefficients(const EngineSetup& setup);

}  // namespace granary::dem
