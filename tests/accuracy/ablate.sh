#!/bin/sh
# What each effect contributes in the small chute at 0 and at 16 rpm: tables of `granary ablate`, written to
# DIR. Usage: ablate.sh [DIR]. About two minutes of one core.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$here/tests/accuracy/results}
granary=$here/build/release/bin/granary
mkdir -p "$out"
GRANARY_DATA=$(mktemp -d); export GRANARY_DATA
trap 'rm -rf "$GRANARY_DATA"' EXIT
for rpm in 0 16; do
  "$granary" ablate "$here/tests/scenes/chute_small.txtpb" --set chute.rotation_rpm=$rpm \
    --set effects.gas=AUTO --replicates 6 --observable exit_speed_m_per_s --observable particle_count \
    --effect gas --effect rotating_frame --effect particle_rotation --effect tangential_history \
    --effect chute.contact_pw.friction_coefficient=0.11 \
    --effect chute.contact_pp.tangential_restitution=0.9 > "$out/ablate_chute_small_${rpm}_rpm.txt"
done
