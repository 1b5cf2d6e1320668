"""A private server with workers for the scripts of this folder, and the client to talk to it."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
BIN = ROOT / "build/release/bin"
SCENES = ROOT / "tests/scenes"


class Service:
    """`with Service(workers=2) as service:`; everything is removed at the end unless `data` is given:
    then results stay there, and the next call computes nothing twice."""

    def __init__(self, workers, data=None):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="granary-papers-"))
        self.data = pathlib.Path(data).resolve() if data else self.folder / "data"
        self.address = f"unix:{self.folder}/server.sock"
        self.workers = workers

    def __enter__(self):
        self.environment = {"PATH": os.environ["PATH"], "HOME": str(self.folder), "GRANARY_DATA": str(self.data)}
        self.up = subprocess.Popen(
            [BIN / "granary", "up", "--workers", str(self.workers), "--listen", self.address],
            env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.environment["GRANARY_SERVER"] = self.address
        while self.granary("health", check=False).returncode != 0:
            if self.up.poll() is not None:
                raise RuntimeError("granary up has ended")
        return self

    def __exit__(self, *_):
        self.up.terminate()
        self.up.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def granary(self, *arguments, text=None, check=True):
        return subprocess.run([BIN / "granary", *map(str, arguments)], env=self.environment, input=text,
                              capture_output=True, text=True, check=check)

    def rows(self, *arguments, **more):
        return json.loads(self.granary(*arguments, "--format", "json", **more).stdout)

    def query(self, sql):
        return self.rows("query", sql)

    def optimize(self, study_text):
        """Runs a study to its end: its row of `study ls`, and its trials."""
        name = self.granary("optimize", "-", text=study_text).stdout.strip()
        self.granary("watch", name, "-q")
        study = next(row for row in self.rows("study", "ls", "--limit", 0) if row["study"] == name)
        return study, self.rows("study", "history", name)


def wall_variables(minimum=-1.0, maximum=0.0):
    return "\n".join(f'vary {{ path: "discharge.bucket.x{k}_m" minimum: {minimum} maximum: {maximum} }}'
                     for k in (2, 3, 4))


def criteria(weights):
    """Eq. 12 of the bucket-elevator paper; f3(x0) may be 0, so its scale is at least 1 %."""
    keys = ("f1_m", "f2_m", "f3_percent", "f4_m")
    goals = ("MAXIMISE", "MAXIMISE", "MINIMISE", "MINIMISE")
    return "\n".join(f'objective {{ value: "{key}" weight: {weight} goal: {goal} floor: {1 if key == "f3_percent" else 0} }}'
                     for key, goal, weight in zip(keys, goals, weights))


def closedness(inputs):
    """Mean distance [m] of the Bezier wall outside the straight line x1 - x5: > 0 closed, < 0 open.
    All five ordinates are evenly spaced, so y is linear in theta and the mean is that of the abscissae."""
    return (-0.6 - sum(float(inputs[f"discharge.bucket.x{k}_m"]) for k in (2, 3, 4))) / 5
