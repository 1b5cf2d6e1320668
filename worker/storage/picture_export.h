// A result as one picture: six moments of a discharge side by side (disks by stratum, bucket turned
// with the pulley) or of a chute seen from the side (grains by speed), as SVG that opens anywhere.
#pragma once

#include "worker/storage/file_system.h"

namespace granary::storage {

// Writes directory/picture.svg and returns its path. Throws StorageError, also when there are no
// frames to draw.
Path export_picture(const Path& result, const Path& directory);

}  // namespace granary::storage
