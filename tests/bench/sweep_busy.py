#!/usr/bin/env python3
"""How busy a sweep keeps its workers: 3 x 40 trials on two workers, then the same again, which must run
nothing. Busy = time with a task assigned / (slots x time from the first start to the last end).

    tests/bench/sweep_busy.py [--disks 200]"""
import argparse
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "physics/design"))
from service import SCENES, Service  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--disks", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    with Service(options.workers) as service:
        sweep = ["sweep", SCENES / "discharge_small.txtpb", "--set", f"discharge.particles.count={options.disks}",
                 "--vary", "discharge.friction_pp_deg=30,40,47", "--vary", "discharge.rotation_rad_per_s=7:12:40", "--wait", "-q"]
        started = time.time()
        service.granary(*sweep)
        elapsed = time.time() - started
        row = service.query("SELECT count(*) AS tasks, sum(julianday(ended) - julianday(started)) AS busy, "
                            "max(julianday(ended)) - min(julianday(started)) AS span FROM tasks")[0]
        share = 100 * row["busy"] / (options.workers * row["span"])
        print(f"{row['tasks']} tasks in {elapsed:.1f} s, workers busy {share:.1f} %")
        started = time.time()
        service.granary(*sweep)
        again = service.query("SELECT count(*) AS tasks FROM tasks")[0]["tasks"] - row["tasks"]
        print(f"again: {again} tasks, {time.time() - started:.2f} s")


main()
