#!/usr/bin/env python3
"""What an effect that is switched off costs, and what the energy ledger and the sentinels cost.

Instructions, counted by callgrind on the portable kernels of short runs of two shipped scenes:
 - an effect that is off, against kernels from whose source every line of that effect was deleted;
 - ledger and sentinels, against kernels that keep no books (worker/core/books.h), plus what the
   functions cost that exist for nothing else (sentinels after a step, marks, flushing the ledger).
CPU seconds, on this machine's fastest kernels: the same two builds in turn, A B A B, minimum of each.

Usage: effect_cost.py [--part effects|books] [--rounds N] [-o FILE.md]. Needs a release build, valgrind (apt install valgrind); some
minutes of one core. Prints a table; -o writes it.
"""
import argparse
import json
import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BUILD = os.path.join(ROOT, "build", "release")
KERNEL_SOURCES = {
    "dda": ["kernel_narrow_phase.h", "kernel_one_solve.h", "kernel_small_steps.h", "kernel_table.h"],
    "dem": ["kernels_body.h", "lanes_portable.h"],
}
SCENES = {
    "dda": ("discharge_small", []),
    "dem": ("chute_small", ["chute.duration_s=0.1", "chute.length_m=0.1", "chute.sample_start_s=0.05"]),
}
TIMED = {"dda": ("discharge_700_centrifugal", []), "dem": ("chute_small", [])}
# Functions that exist for the books alone; {step} is what they are compared with.
STEP = {"dda": r"^granary::dda::step\(", "dem": r"^granary::dem::BlockEngine::advance\("}
ALWAYS = {
    "dda": [r"DischargeSimulation::check_sentinels\(", r"^granary::scene::DischargeSimulation::snapshot\("],
    "dem": [r"^granary::scene::ChuteSimulation::snapshot\("],
}
INSIDE_STEP = {"dda": [], "dem": [r"BlockEngine::flush_ledger\(", r"BlockEngine::begin_ledger_span\("]}


# ------------------------------------------------------------------ kernels without an effect

def statement_end(text, start):
    """Behind the statement that begins at `start`: a block, or up to its semicolon."""
    depth = 0
    k = start
    while True:
        c = text[k]
        if c in "({[":
            depth += 1
        elif c in ")}]":
            depth -= 1
            if depth == 0 and c == "}" and text[start] == "{":
                return k + 1
        elif c == ";" and depth == 0:
            return k + 1
        k += 1


def skip_space(text, k):
    while text[k].isspace():
        k += 1
    return k


def if_end(text, start):
    """Behind an if constexpr with all its branches, or any other statement."""
    if not text.startswith("if constexpr", start):
        return statement_end(text, start)
    body = skip_space(text, text.index(")", start) + 1)
    end = statement_end(text, body)
    follow = skip_space(text, end)
    return if_end(text, skip_space(text, follow + 4)) if text.startswith("else", follow) else end


def without(text, flag):
    """The source with every branch taken as if the effect had never been thought of."""
    while True:
        found = re.search(r"if constexpr \((!?)(?:kEffects\.)?%s\)\s*" % flag, text)
        if not found:
            break
        begin, body = found.start(), found.end()
        end = statement_end(text, body)
        kept = text[body:end] if found.group(1) else ""
        follow = skip_space(text, end)
        if text.startswith("else", follow):
            other = skip_space(text, follow + 4)
            end = if_end(text, other)
            if not found.group(1):
                kept = text[other:end]
        text = text[:begin] + kept + text[end:]
    text = re.sub(r"kEffects\.%s \? ([^;]*?) : ([^;,]*?)([;,)])" % flag, r"\2\3", text)
    return text.replace("kEffects.%s" % flag, "false")


# What is left of an effect where it needs no test.
def without_sums(text, name):
    text = re.sub(r"\n *sums\.%s \+= [^;]*;" % name, "", text)
    return text


def kernels_without(engine, edit, folder):
    for name in KERNEL_SOURCES[engine]:
        path = os.path.join("worker", engine, name)
        with open(os.path.join(ROOT, path)) as source:
            text = edit(source.read())
        os.makedirs(os.path.join(folder, "worker", engine), exist_ok=True)
        with open(os.path.join(folder, path), "w") as copy:
            copy.write(text)


# --------------------------------------------------------------------------------- programs

def compile_commands():
    with open(os.path.join(BUILD, "compile_commands.json")) as file:
        return {os.path.relpath(c["file"], ROOT): c["command"] for c in json.load(file)}


def compiled(source, folder, flags, copy=None):
    """Object of `source` or its copy, headers in `folder` before those of the repository."""
    command = shlex.split(compile_commands()[source])
    command[-1] = copy or command[-1]
    target = os.path.join(folder, source.replace("/", "_") + ".o")
    command[command.index("-o") + 1] = target
    command[1:1] = ["-w", "-I" + folder] + flags
    if shutil.which("ccache") and "ccache" not in command[0]:
        command.insert(0, "ccache")
    subprocess.run(command, cwd=BUILD, check=True)
    return target


def linked(objects, target):
    """granary-worker with these objects in place of those of the same names in its libraries."""
    listed = subprocess.run(["ninja", "-t", "commands", "bin/granary-worker"], cwd=BUILD, check=True,
                            capture_output=True, text=True).stdout.splitlines()[-1]
    command = shlex.split(listed.split("&&")[1])
    at = command.index("-o")
    command[at + 1] = target
    command[at:at] = objects
    subprocess.run(command, cwd=BUILD, check=True)
    return target


def portable_worker(folder, flags=(), also=()):
    os.makedirs(folder, exist_ok=True)
    flags = list(flags)
    objects = []
    for engine in ("dda", "dem"):
        source = f"worker/{engine}/kernels.cpp"
        os.makedirs(os.path.join(folder, "worker", engine), exist_ok=True)
        with open(os.path.join(ROOT, source)) as given, open(os.path.join(folder, source), "w") as only:
            only.write(given.read().replace("defined(__x86_64__)", "0"))
        objects.append(compiled(source, folder, flags, os.path.join(folder, source)))
    objects += [compiled(f"worker/{engine}/kernels_portable.cpp", folder, flags)
                for engine in ("dda", "dem")]
    objects += [compiled(source, folder, flags) for source in also]
    return linked(objects, os.path.join(folder, "granary-worker"))


def fastest_worker(folder, flags):
    """Everything that looks at kBooks."""
    os.makedirs(folder, exist_ok=True)
    sources = [f"worker/{engine}/kernels_{path}.cpp" for engine in ("dda", "dem")
               for path in ("portable", "avx2", "avx512")] + BOOKS_SOURCES
    objects = [compiled(s, folder, flags) for s in sources if s in compile_commands()]
    return linked(objects, os.path.join(folder, "granary-worker"))


BOOKS_SOURCES = ["worker/dda/small_steps.cpp", "worker/scene/discharge_recovery.cpp",
                 "worker/scene/chute_simulation.cpp", "worker/run/watched_engine.cpp"]


# ------------------------------------------------------------------------------- measurements

def scene_arguments(scene_and_settings, settings=()):
    scene, shared = scene_and_settings
    arguments = ["--scene", os.path.join(ROOT, "tests", "scenes", scene + ".txtpb"), "-q"]
    for setting in shared + list(settings):
        arguments += ["--set", setting]
    return arguments


def instructions(program, engine, settings, folder):
    """Inclusive instructions by function."""
    out = os.path.join(folder, "callgrind.out")
    subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=" + out, program]
                   + scene_arguments(SCENES[engine], settings),
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    listing = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", out],
                             check=True, capture_output=True, text=True).stdout
    counts = {}
    for line in listing.splitlines():
        found = re.match(r"\s*([\d,]+) (?:\([^)]*\)\s+)?\S*?:(.*?)(?: \[.*\])?$", line)
        if found:
            counts[found.group(2)] = int(found.group(1).replace(",", ""))
    return counts


def count_of(counts, pattern):
    matching = [n for name, n in counts.items() if re.search(pattern, name) and "'2" not in name]
    return max(matching, default=0)


def cpu_seconds(program, engine):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([program] + scene_arguments(TIMED[engine]), check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


# --------------------------------------------------------------------------------- the table

# engine, effect, its flags in the source, sums that need no test, scene that switches it off
EFFECTS = [
    ("dda", "rolling_friction", "rolling", ["rolling"], []),
    ("dda", "cohesion", "cohesion", ["cohesion"], []),
    ("dda", "tangential_history", "history", ["stick_work", "stick_change"],
     ["effects.tangential_history=OFF"]),
    ("dda", "particle_rotation", "rotation", [], ["effects.particle_rotation=OFF"]),
    ("dem", "rolling_friction", "rolling_friction", ["rolling"], []),
    ("dem", "cohesion", "cohesion", [], []),
    ("dem", "tangential_history", "tangential_history", [], ["effects.tangential_history=OFF"]),
    ("dem", "particle_rotation", "spin kTurns", [], ["effects.particle_rotation=OFF"]),
    ("dem", "rotating_frame", "kRotating", [], []),
]


def edit_without(flags, sums):
    def edit(text):
        for flag in flags.split():
            text = without(text, flag)
        for name in sums:
            text = without_sums(text, name)
        return text
    return edit


def effect_rows(work, base):
    cache = {}
    for engine, effect, flags, sums, off in EFFECTS:
        folder = os.path.join(work, f"{engine}_{effect}")
        kernels_without(engine, edit_without(flags, sums), folder)
        key = (engine, tuple(off))
        if key not in cache:
            cache[key] = count_of(instructions(base, engine, off, work), STEP[engine])
        bare = count_of(instructions(portable_worker(folder), engine, off, work), STEP[engine])
        yield engine, effect, cache[key], bare


def books_rows(work, base, rounds):
    flags = ["-DGRANARY_WITHOUT_BOOKS"]
    bare = portable_worker(os.path.join(work, "no_books"), flags, BOOKS_SOURCES)
    fast = [fastest_worker(os.path.join(work, "fast"), []),
            fastest_worker(os.path.join(work, "fast_no_books"), flags)]
    for engine in SCENES:
        with_books = instructions(base, engine, [], work)
        without_books = instructions(bare, engine, [], work)
        alone = sum(count_of(with_books, p) for p in ALWAYS[engine])
        inside = sum(count_of(without_books, p) for p in INSIDE_STEP[engine])
        seconds = [[], []]
        for _ in range(rounds):
            for k in (0, 1):
                seconds[k].append(cpu_seconds(fast[k], engine))
        yield (engine, count_of(with_books, STEP[engine]) + alone,
               count_of(without_books, STEP[engine]) - inside, min(seconds[0]), min(seconds[1]))


def table(work, part, rounds):
    base = portable_worker(os.path.join(work, "base"))
    if part != "books":
        yield from effects_table(work, base)
    if part != "effects":
        yield from books_table(work, base, rounds)


def effects_table(work, base):
    yield "| engine | effect that is off | instructions of the steps, 1e6 | kernels without it | cost |"
    yield "| --- | --- | --- | --- | --- |"
    for engine, effect, count, bare in effect_rows(work, base):
        yield f"| {engine} | {effect} | {count / 1e6:.1f} | {bare / 1e6:.1f} | {100 * (count / bare - 1):.2f} % |"
    yield ""


def books_table(work, base, rounds):
    yield ("| engine | ledger and sentinels: instructions, 1e6 | without | cost | CPU s, minimum | without | cost |")
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for engine, count, bare, slow, fast in books_rows(work, base, rounds):
        yield (f"| {engine} | {count / 1e6:.1f} | {bare / 1e6:.1f} | {100 * (count / bare - 1):.2f} % | "
               f"{slow:.3f} | {fast:.3f} | {100 * (slow / fast - 1):.1f} % |")


def main():
    os.environ["GRANARY_CALIBRATION"] = ""  # runs under valgrind say nothing about this host's speed
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=["effects", "books"], help="default: both")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("-o", "--output")
    options = parser.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("effect_cost.py: valgrind is missing (apt install valgrind)")
    with tempfile.TemporaryDirectory() as work:
        lines = []
        for line in table(work, options.part, options.rounds):
            print(line, flush=True)
            lines.append(line)
    if options.output:
        with open(options.output, "w") as file:
            file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
