#!/usr/bin/env python3
"""Aggregate queries over a million stored jobs, through the query door: seconds until the client has its
answer, and CPU seconds of the server (on a shared machine the better figure).

    tests/bench/query_million.py [--jobs 1000000] [--bin build/release/bin]

The jobs are copies of one real discharge, with values of their own; every 40th has failed."""
import argparse
import os
import pathlib
import sqlite3
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
QUERIES = {
    "jobs by state": "SELECT state, count(*) FROM jobs GROUP BY state",
    "mean of a value": "SELECT avg(f1_m), max(f1_m) FROM discharge_values",
    "failed jobs by cause": "SELECT error, count(*) FROM jobs WHERE state = 'error' GROUP BY error",
    "cost of everything": "SELECT sum(cpu_s) FROM jobs",
    "best f1 per rotation rate": 'SELECT "discharge.rotation_rad_per_s", max(f1_m) FROM discharge_values GROUP BY 1',
    "one job by name": "SELECT state, f1_m FROM discharge_values WHERE job = 'jobs/77777'",
    "newest ten": "SELECT job, state FROM jobs ORDER BY submitted DESC LIMIT 10",
}


def fill(database, jobs):
    connection = sqlite3.connect(database)
    connection.execute("PRAGMA synchronous = OFF")
    columns = [row[1] for row in connection.execute("PRAGMA table_info(job)") if row[1] not in ("id", "state", "error")]
    names = ", ".join(columns)
    connection.execute(f"""WITH RECURSIVE n(i) AS (SELECT 2 UNION ALL SELECT i + 1 FROM n LIMIT {jobs - 1})
        INSERT INTO job (id, state, error, {names})
        SELECT i, CASE WHEN i % 40 = 0 THEN 4 ELSE 3 END, CASE WHEN i % 40 = 0 THEN 'cause ' || (i % 7) ELSE '' END,
        {names} FROM n, job WHERE job.id = 1""")
    connection.execute("INSERT INTO job_value SELECT j.id, v.name, v.value + j.id * 1e-7, v.error, v.unit, v.error_basis "
                       "FROM job j, job_value v WHERE v.job = 1 AND v.name LIKE 'f%' AND j.id > 1 AND j.state = 3")
    connection.execute("INSERT INTO job_cost SELECT j.id, wall_s, cpu_s, reused_s, steps, particle_steps, ns_per_particle_step, "
                       "contacts_per_particle, threads, peak_rss_bytes, remainder_ratio FROM job j, job_cost c "
                       "WHERE c.job = 1 AND j.id > 1")
    connection.commit()
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    connection.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1_000_000)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        address = f"unix:{folder}/s"
        environment = {"PATH": os.environ["PATH"], "HOME": folder, "GRANARY_SERVER": address, "GRANARY_DATA": f"{folder}/data"}

        def granary(*arguments):
            return subprocess.run([options.bin / "granary", *arguments], env=environment, capture_output=True, text=True)

        def server_cpu_s(up):
            children = pathlib.Path(f"/proc/{up.pid}/task/{up.pid}/children").read_text().split()
            server = next(pid for pid in children if "granaryd" in pathlib.Path(f"/proc/{pid}/cmdline").read_text())
            fields = pathlib.Path(f"/proc/{server}/stat").read_text().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

        def with_server(workers, work):
            up = subprocess.Popen([options.bin / "granary", "up", "--workers", str(workers), "--listen", address],
                                  env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                while granary("health").returncode != 0:
                    pass
                work(up)
            finally:
                up.terminate()
                up.wait()

        scene = ROOT / "tests/scenes/discharge_small.txtpb"
        with_server(1, lambda _: granary("submit", str(scene), "--set", "discharge.particles.count=40", "--wait"))
        fill(f"{folder}/data/granary.db", options.jobs)

        def ask(up):
            print(f"{options.jobs} jobs, database {os.path.getsize(f'{folder}/data/granary.db') / 1e6:.0f} MB\n")
            print("| query | s | server CPU s |\n|---|---|---|")
            for name, sql in QUERIES.items():
                seconds, cpu = [], []
                for _ in range(3):
                    start, before = time.perf_counter(), server_cpu_s(up)
                    answer = granary("query", sql, "--format", "json", "--time-limit", "60s")
                    seconds.append(time.perf_counter() - start)
                    cpu.append(server_cpu_s(up) - before)
                    assert answer.returncode == 0, answer.stderr
                print(f"| {name} | {min(seconds):.3f} | {min(cpu):.2f} |")

        with_server(1, ask)


main()
