// A contact of a grain with the mesh in the block engine: the law of contact_law.h in double,
// booked as the kernels book theirs (book() in kernels_body.h). The normal points from the mesh to
// the grain.
#pragma once

#include <cstdint>

#include "worker/dem/contact_law.h"
#include "worker/dem/kernels.h"
#include "worker/dem/records.h"
#include "worker/dem/surface_mesh.h"

namespace granary::dem {

// What is kept of a contact between two steps; also a slot of assign_touches().
struct MeshContact {
  std::uint32_t grain = 0;  // place in the engine's arrays
  SurfaceTouch touch;
  core::Vec3 spring;    // tangential elongation [m]; without history: tangential force [N]
  core::Vec3 velocity;  // at the contact in the last step [m/s]
  bool touching = false;
  bool is_met = false;

  History history() const;  // as the kernels keep it
};

// The law for one class of grains.
struct MeshLaw {
  ContactCoefficients law;
  ContactEffects effects;
  double spin_response = 0;  // R / I; 0 without spin
  double time_step = 0;      // s
};

// One step of a contact that is met: moves its spring, adds to load and sums.
void push(MeshContact& contact, const MeshLaw& law, const GrainMotion& motion,
          const GrainSurface& surface, GrainLoad& load, ContactSums& sums);

// A contact that has opened: books what was still to come and what its spring held.
void part(const MeshContact& contact, const MeshLaw& law, const GrainMotion& motion,
          const GrainSurface& surface, ContactSums& sums);

}  // namespace granary::dem
