#!/bin/sh
# What each effect contributes in the small chute at 0 and at 16 rpm and in a discharge, and whether `effects:
# AUTO` has decided as these measurements say: tables of `granary ablate` and effects.md, written to DIR.
# Usage: ablate.sh [DIR]. About three minutes of one core.
set -eu
. "$(dirname "$0")/study.sh"
auto() {  # NAME SCENE OPTIONS..: what AUTO decides at 1 % and at 5 %
  name=$1; scene=$scenes/$2.txtpb; shift 2
  for target in 0.01 0.05; do
    "$granary" check "$scene" "$@" --set accuracy.target=$target --format json > "$out/$name.$target" 2> /dev/null
  done
}
for rpm in 0 16; do
  observable=exit_speed_m_per_s
  set -- --set chute.rotation_rpm=$rpm --set effects.gas=AUTO
  auto chute_small_${rpm}_rpm chute_small "$@" --set accuracy.observable=$observable
  study ablate chute_small_${rpm}_rpm chute_small "$@" --replicates 6 \
    --observable $observable --observable particle_count \
    --effect gas --effect rotating_frame --effect particle_rotation --effect tangential_history \
    --effect rolling_friction --effect cohesion \
    --effect chute.contact_pw.friction_coefficient=0.11 \
    --effect chute.contact_pp.tangential_restitution=0.9
done
set -- --set effects.gas=AUTO
auto discharge_700_centrifugal discharge_700_centrifugal "$@" --set accuracy.observable=f1_m
study ablate discharge_700_centrifugal discharge_700_centrifugal "$@" --replicates 12 \
  --observable f1_m --observable f1_landing_m --observable f4_m --observable a50_deg \
  --effect gas --effect particle_rotation --effect tangential_history --effect rolling_friction --effect cohesion \
  --effect discharge.friction_pw_deg=20 --effect discharge.rolling_friction_coefficient=0.1
python3 "$here/tests/accuracy/effects.py" "$out" chute_small_0_rpm chute_small_16_rpm \
  discharge_700_centrifugal > "$out/effects.md"
rm "$out"/*.0.01 "$out"/*.0.05
cat "$out/effects.md"
