// The frames of a result file in the forms that viewers of particles read: extended XYZ (OVITO,
// ASE) and VTK polygonal data with a collection over time (ParaView). All particles, SI units,
// plane scenes at z = 0. Existing files of these names are replaced. Throws StorageError.
#pragma once

#include <vector>

#include "worker/storage/file_system.h"

namespace granary::storage {

// frames.xyz: one block per frame; the second line of each names the columns and the time.
std::vector<Path> export_xyz(const Path& result, const Path& directory);

// frames.pvd and one frames/NNNNNN.vtp per frame; vectors as 3 components, values as Float32.
std::vector<Path> export_paraview(const Path& result, const Path& directory);

}  // namespace granary::storage
