#!/usr/bin/env python3
"""Search methods against each other at equal evaluations over paired seeds, on a bucket wall of few disks.

    tests/physics/design/compare_methods.py --seeds 8 --budget 40

Each seed starts every method from the same wall and the same stream of random numbers. Reported: the best
objective of each method (1 = the start), and each method's paired difference to the paper's own algorithm
(gradual deformation, CONVEX) with its 95 % interval (Student's t over the seeds)."""
import argparse
import math

from service import SCENES, Service, criteria, wall_variables

METHODS = {
    "gradual deformation (paper)": "method: GRADUAL_DEFORMATION gradual_deformation { mixing: CONVEX }",
    "gradual deformation (Gaussian)": "method: GRADUAL_DEFORMATION gradual_deformation { mixing: GAUSSIAN }",
    "CMA-ES": "method: CMA_ES",
    "random search": "method: RANDOM_SEARCH",
}
T_95 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131)


def mean_and_error(values):
    mean = sum(values) / len(values)
    if len(values) < 2:
        return mean, math.nan
    deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
    return mean, T_95[min(len(values) - 2, len(T_95) - 1)] * deviation / math.sqrt(len(values))


def study(method, seed, options):
    return f"""scene_file: "{SCENES}/discharge_small.txtpb" seed: {seed}
set: "discharge.particles.count={options.disks}" set: "discharge.bucket.shape=BEZIER"
set: "discharge.bucket.x2_m=-0.02" set: "discharge.bucket.x3_m=-0.04" set: "discharge.bucket.x4_m=-0.06"
optimize {{ {METHODS[method]} budget: {options.budget} {wall_variables(-0.2, 0.0)} {criteria((1, 1, 1, 1))} }}"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--budget", type=int, default=40, help="evaluations per method and seed")
    parser.add_argument("--disks", type=int, default=150)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    best = {method: [] for method in METHODS}
    with Service(options.workers) as service:
        for seed in range(1, options.seeds + 1):
            for method in METHODS:
                row, _ = service.optimize(study(method, seed, options))
                best[method].append(row["best_objective"] if row["best_objective"] is not None else -math.inf)
    print(f"{options.seeds} seeds, {options.budget} evaluations each, {options.disks} disks, weights 1/1/1/1\n")
    print("| method | best objective | minus the paper's algorithm |\n|---|---|---|")
    paper = best[next(iter(METHODS))]
    for method, values in best.items():
        mean, error = mean_and_error(values)
        gain, gain_error = mean_and_error([a - b for a, b in zip(values, paper)])
        print(f"| {method} | {mean:.4f} +- {error:.4f} | {gain:+.4f} +- {gain_error:.4f} |")


main()
