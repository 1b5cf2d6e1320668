#!/bin/sh
# What accuracy costs on two shipped scenes, and Table 1 of the bucket paper, whose penalty grows from each of
# the ladder's rungs: tables, json and plots of `granary price`, written to DIR.
# Usage: price.sh [DIR]. About three minutes of one core.
set -eu
. "$(dirname "$0")/study.sh"
study price discharge_700_centrifugal discharge_700_centrifugal --observable f1_m --observable f3_percent \
  --replicates 6
study price chute_small chute_small --observable exit_speed_m_per_s --observable particle_count --replicates 4
# The paper names neither its bucket nor its step: a hundred beads, settled at 1e6 N/m, turned by 1.68 rad/s.
study price table_1 discharge_small --observable penalty_final_n_per_m --observable open_close_iterations \
  --ladder discharge.penalty.stiffness_n_per_m --rungs 4 --ratio 10 --replicates 4 \
  --set discharge.penalty.stiffness_n_per_m=1e4 --set discharge.particles.count=100 \
  --set discharge.bucket.tip_x_m=-0.055 --set discharge.bucket.tip_y_m=0.055 \
  --set discharge.rotation_rad_per_s=1.68 --set discharge.time_step_s=5e-4 \
  --set discharge.filling_time_step_s=2e-4 --set discharge.filling_stiffness_n_per_m=1e6 \
  --set discharge.solver.method=OPEN_CLOSE
