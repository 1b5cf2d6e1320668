#!/usr/bin/env python3
"""Accuracy asked for against accuracy got: eight shipped scenes, three targets each, every answer compared with the
finest reference (a quarter of the time step, many replicates). An interval holds the reference when
|value - reference| <= hypot(error, reference error).

Prints a table, what it has cost beside always taking the finest, and how many intervals hold. Exits with 1 when
fewer than 90 % of all intervals do, or of the observables asked for so few that 90 % are ruled out at 1 %
(binomial). Usage: coverage.py [SCENE..]. Some fifteen CPU minutes for all.
"""
import concurrent.futures
import json
import math
import os
import subprocess
import sys

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
TARGETS = (0.1, 0.05, 0.02)
LEAST_COVERAGE = 0.9
REPLICATES = 64

# scene: observable, a quarter of the default step, what makes it affordable
SCENES = {
    "discharge_small": ("f1_m", "5e-5", []),
    "discharge_700_centrifugal": ("f1_m", "5e-5", []),
    "discharge_700_gravity": ("f1_landing_m", "5e-5", []),
    "discharge_m_type_ordered": ("f1_m", "5e-5", []),
    "discharge_ka_0_8": ("f1_landing_m", "5e-5", []),
    "discharge_ka_2_a": ("f2_m", "5e-5", []),
    "discharge_ka_2_d": ("f1_m", "5e-5", []),
    "chute_small": ("exit_speed_m_per_s", "2.5e-6", [
        "chute.length_m=0.1", "chute.duration_s=0.25", "chute.sample_start_s=0.15"]),
}
# Of other meaning than an estimate with an error: fixed by the scene, or a count of what was filled in.
NOT_ESTIMATED = {"steady_from_s"}


def run(scene, settings):
    command = [os.path.join(ROOT, "build/release/bin/granary-worker"), "--scene",
               os.path.join(ROOT, "tests/scenes", scene + ".txtpb"), "-q", "--format", "json"]
    for setting in settings:
        command += ["--set", setting]
    done = subprocess.run(command, check=True, capture_output=True, text=True,
                          env={**os.environ, "GRANARY_CALIBRATION": ""})
    return json.loads(done.stdout)


def known(values):
    return {name: q for name, q in values.items()
            if q.get("value") is not None and q.get("error") is not None and name not in NOT_ESTIMATED}


def holds(quantity, reference):
    return abs(quantity["value"] - reference["value"]) <= math.hypot(quantity["error"], reference["error"])


def fewest(count, share):
    """Fewer successes than this of `count` have less than 1 % when each succeeds with `share`."""
    total, k = 0.0, 0
    while True:
        total += math.comb(count, k) * share ** k * (1 - share) ** (count - k)
        if total >= 0.01:
            return k
        k += 1


class Tally:
    def __init__(self):
        self.asked = self.asked_held = self.all = self.all_held = self.met = 0
        self.cpu_s = self.finest_s = 0.0

    def row(self, scene, observable, target, got, reference):
        values, finest = known(got["values"]), known(reference["values"])
        quantity, truth = values[observable], finest[observable]
        held = {name: holds(q, finest[name]) for name, q in values.items() if name in finest}
        share = quantity["error"] / abs(quantity["value"])
        cpu_s, finest_s = got["cost"]["cpu_s"], reference["cost"]["cpu_s"]
        self.asked += 1
        self.asked_held += held[observable]
        self.all += len(held)
        self.all_held += sum(held.values())
        self.met += share <= target
        self.cpu_s += cpu_s
        self.finest_s += finest_s
        off = abs(quantity["value"] - truth["value"]) / abs(truth["value"])
        print(f"| {scene} | {observable} | {100 * target:g} % | {quantity['value']:.5g} | {100 * share:.2g} % | "
              f"{100 * off:.2g} % | {'yes' if held[observable] else 'NO'} | {sum(held.values())} of {len(held)} | "
              f"{cpu_s:.1f} | {finest_s:.1f} |", flush=True)

    def summary(self):
        bound = fewest(self.asked, LEAST_COVERAGE)
        print(f"\n{self.asked_held} of {self.asked} intervals asked for hold the reference (fewer than {bound} would "
              f"rule out 90 %); {self.all_held} of {self.all} of all observables. {self.met} errors are within the "
              f"target. CPU {self.cpu_s:.0f} s, always the finest {self.finest_s:.0f} s: "
              f"{100 * (1 - self.cpu_s / self.finest_s):.0f} % saved.")
        return self.asked_held >= bound and self.all_held >= LEAST_COVERAGE * self.all


def results_of(scene):
    """The reference, then the answer for each target."""
    observable, step, settings = SCENES[scene]
    path = ("chute" if scene.startswith("chute") else "discharge") + ".time_step_s=" + step
    results = [run(scene, settings + [path, f"replicates={REPLICATES}", "seed=4711"])]
    for target in TARGETS:
        results.append(run(scene, settings + [f"accuracy.target={target}", f"accuracy.observable={observable}"]))
    return results


def main():
    tally = Tally()
    print("| scene | observable | target | value | error given | off the reference | holds | of all observables | "
          "CPU s | always the finest, CPU s |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    scenes = sys.argv[1:] or list(SCENES)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for scene, results in zip(scenes, pool.map(results_of, scenes)):
            for target, got in zip(TARGETS, results[1:]):
                tally.row(scene, SCENES[scene][0], target, got, results[0])
    sys.exit(0 if tally.summary() else 1)


if __name__ == "__main__":
    main()
