#!/usr/bin/env python3
"""Who may include whom: includes start at the root, so path = module = layer. Prints every include
that the table does not allow, and exits 1. With --self-test it must find a planted violation."""
import pathlib
import re
import sys
import tempfile

CONTRACT = {"proto/contract", "granary/v1"}
RULES = {
    "proto/contract": {"granary/v1"},
    "worker/core": set(),
    "worker/dem": {"worker/core"},
    "worker/dda": {"worker/core"},
    "worker/gas": {"worker/core"},
    "worker/measure": {"worker/core", "worker/dem", "worker/dda", "worker/gas"},
    "worker/storage": {"worker/core"},
    "worker/scene": CONTRACT | {"worker/core", "worker/dem", "worker/dda", "worker/gas", "worker/measure"},
    "worker/run": CONTRACT | {"worker/scene", "worker/core", "worker/measure", "worker/storage"},
    "worker/agent": CONTRACT | {"worker/run"},
    "server/workers": CONTRACT,
    "server/jobs": CONTRACT | {"server/workers"},
    "server/studies": CONTRACT | {"server/jobs"},
    "server/store": CONTRACT | {"server/jobs", "server/workers", "server/studies"},
    "server/artifacts": CONTRACT,
    "server/api": CONTRACT | {"server/jobs", "server/workers", "server/studies", "server/store",
                              "server/artifacts"},
    "server/ops": CONTRACT | {"server/jobs", "server/workers", "server/studies", "server/store",
                              "server/artifacts", "server/api"},
    "client/session": CONTRACT,
    "client/render": CONTRACT,
    "client/commands": CONTRACT | {"client/session", "client/render"},
}
# Libraries that may appear in headers of one module only.
HEADER_ONLY_IN = {
    "hdf5.h": {"worker/storage"},
    "SQLiteCpp/": {"server/store"},
    "sqlite3.h": {"server/store"},
    "pagmo/": set(),  # 10 s to compile: in source files only
    "grpcpp/": {"server/api", "server/ops", "client/session", "client/commands", "worker/agent"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]', re.M)


def module_of(path):
    parts = pathlib.PurePosixPath(path).parts
    return "/".join(parts[:2]) if len(parts) > 2 else None


def violations(root):
    root = pathlib.Path(root)
    for file in sorted(root.rglob("*")):
        relative = file.relative_to(root).as_posix()
        if file.suffix not in (".h", ".cpp") or not relative.startswith(("proto/", "server/", "client/", "worker/")):
            continue
        module = module_of(relative)
        if module is None:  # main.cpp: wiring may see its own program only
            module_root = relative.split("/")[0]
            for target in INCLUDE.findall(file.read_text()):
                if target.startswith(("server/", "client/", "worker/")) and not target.startswith(module_root + "/"):
                    yield f"{relative}: may not include {target}"
            continue
        if module not in RULES:
            yield f"{relative}: module {module} is not in the table of tests/style/check_layers.py"
            continue
        for target in INCLUDE.findall(file.read_text()):
            for library, homes in HEADER_ONLY_IN.items():
                if file.suffix == ".h" and target.startswith(library) and module not in homes:
                    yield f"{relative}: {target} may not appear in a header of {module}"
            if not target.startswith(("proto/", "server/", "client/", "worker/", "granary/v1", "tests/")):
                continue
            other = module_of(target)
            if target.startswith("tests/") or (other != module and other not in RULES[module]):
                yield f"{relative}: {module} may not include {target}"


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        bad = pathlib.Path(folder, "worker/dem")
        bad.mkdir(parents=True)
        (bad / "step.cpp").write_text('#include "worker/dda/step.h"\n')
        return len(list(violations(folder))) == 1


def main():
    if "--self-test" in sys.argv:
        sys.exit(0 if self_test() else 1)
    root = pathlib.Path(__file__).resolve().parents[2]
    found = list(violations(root))
    print("\n".join(found) or "layers are clean")
    sys.exit(1 if found else 0)


main()
