#!/bin/sh
# What accuracy costs on two shipped scenes: tables and plots of `granary price`, written to DIR.
# Usage: price.sh [DIR]. About two minutes of one core.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$here/tests/accuracy/results}
granary=$here/build/release/bin/granary
mkdir -p "$out"
GRANARY_DATA=$(mktemp -d); export GRANARY_DATA
trap 'rm -rf "$GRANARY_DATA"' EXIT
"$granary" price "$here/tests/scenes/discharge_700_centrifugal.txtpb" --observable f1_m \
  --observable f3_percent --replicates 6 -o "$out/price_discharge_700_centrifugal.svg" \
  > "$out/price_discharge_700_centrifugal.txt"
"$granary" price "$here/tests/scenes/chute_small.txtpb" --observable exit_speed_m_per_s \
  --observable particle_count --replicates 4 -o "$out/price_chute_small.svg" \
  > "$out/price_chute_small.txt"
