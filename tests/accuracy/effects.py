#!/usr/bin/env python3
"""What `effects: AUTO` decides beside what the ablation measures. Usage: effects.py DIR NAME.. reads
DIR/NAME.0.01 and .0.05 (`granary check --format json` at these targets) and DIR/ablate_NAME.json.

Agrees: an effect left out changes no observable by more than the target or the omitted error that was stated
beforehand, within the interval of what is measured; one that is kept changes one by more, or AUTO had no bound
and keeps it to be safe.
"""
import json
import sys

TARGET = 0.01


def read(path):
    with open(path) as file:
        return json.load(file)


def percent(share):
    return f"{100 * share:.2g} %"


def judged(report, rows):
    """Verdict on one effect from all of its observables."""
    if not rows:
        return "not available to measure"
    if report["on"]:
        needed = any(abs(r["relative"]) - r["relative_error"] > TARGET for r in rows)
        return "agrees: needed" if needed else "kept without a bound; not needed here"
    allowed = max(TARGET, report["omitted_error"] or 0)
    over = [r["observable"] for r in rows if abs(r["relative"]) - r["relative_error"] > allowed]
    return "DISAGREES in " + ", ".join(over) if over else "agrees: left out"


def rows_of(folder, name):
    at_1, at_5 = (read(f"{folder}/{name}.{t}")["effects"] for t in ("0.01", "0.05"))
    measured = [r for r in read(f"{folder}/ablate_{name}.json") if r["relative"] is not None]
    for effect, report in sorted(at_1.items()):
        rows = [r for r in measured if r["effect"] == effect]
        number = "" if report["number"] is None else f"{report['number']:.3g}"
        omitted = "" if report["on"] or report["omitted_error"] is None else percent(report["omitted_error"])
        seen = ", ".join(f"{r['observable']} {percent(r['relative'])} +- {percent(r['relative_error'])}" for r in rows)
        yield (name, effect, "on" if report["on"] else "off", "on" if at_5[effect]["on"] else "off", number,
               omitted, seen or "-", judged(report, rows))
    for effect in sorted({r["effect"] for r in measured} - set(at_1)):
        rows = [r for r in measured if r["effect"] == effect]
        seen = ", ".join(f"{r['observable']} {percent(r['relative'])} +- {percent(r['relative_error'])}" for r in rows)
        strong = any(abs(r["relative"]) - r["relative_error"] > TARGET for r in rows)
        yield name, effect, "", "", "", "", seen, "strong" if strong else "nil at 1 %"


def main():
    print("| scene | effect | auto at 1 % | at 5 % | number | omitted error, stated | measured | verdict |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in sys.argv[2:]:
        for row in rows_of(sys.argv[1], name):
            print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
