#!/bin/sh
# Accuracy asked for against accuracy got: small scenes, three targets each, every answer compared with a fine
# reference (a quarter of the time step, 64 replicates). Prints a table.
# Usage: targets.sh. About ten minutes of one core.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
worker=$here/build/release/bin/granary-worker
run() {  # observable, scene, settings...: value error cpu_s replicates time_step
  observable=$1; scene=$2; shift 2
  "$worker" --scene "$here/tests/scenes/$scene.txtpb" -q --format json "$@" 2>/dev/null |
    python3 -c "
import json, sys
d = json.load(sys.stdin)
q = d['values']['$observable']
print(q['value'], q['error'], d['cost']['cpu_s'])"
}
echo '| scene | observable | target | value | error given | off the reference | inside | CPU s | always the finest, CPU s |'
echo '| --- | --- | --- | --- | --- | --- | --- | --- | --- |'
row() {  # scene observable step-path reference-step settings...
  scene=$1; observable=$2; path=$3; step=$4; shift 4
  set -- "$@"
  reference=$(run "$observable" "$scene" "$@" --set "$path=$step" --set replicates=64)
  for target in 0.1 0.05 0.02; do
    got=$(run "$observable" "$scene" "$@" --set accuracy.target=$target \
      --set accuracy.observable="$observable")
    echo "$scene $observable $target $got $reference" | python3 -c "
s, o, t, v, e, c, rv, re, rc = input().split()
v, e, c, rv, re, rc = map(float, (v, e, c, rv, re, rc))
off = abs(v - rv)
inside = off <= (e * e + re * re) ** 0.5
print(f'| {s} | {o} | {100*float(t):g} % | {v:.5g} | {100*e/abs(v):.2g} % | {100*off/abs(rv):.2g} % | {\"yes\" if inside else \"NO\"} | {c:.1f} | {rc:.1f} |')"
  done
}
dt=discharge.time_step_s
row discharge_small f1_m $dt 5e-5
row discharge_small f4_m $dt 5e-5
row discharge_small f2_m $dt 5e-5 --set discharge.rotation_rad_per_s=6
row discharge_small f1_m $dt 5e-5 --set discharge.rotation_rad_per_s=12
row discharge_small a50_deg $dt 5e-5 --set discharge.friction_pp_deg=20
row discharge_small f2_m $dt 5e-5 --set discharge.normal_restitution=0.5
row chute_small exit_speed_m_per_s chute.time_step_s 2.5e-6 --set chute.duration_s=0.25 --set chute.length_m=0.1 --set chute.sample_start_s=0.15
row chute_small particle_count chute.time_step_s 2.5e-6 --set chute.duration_s=0.25 --set chute.length_m=0.1 --set chute.sample_start_s=0.15
