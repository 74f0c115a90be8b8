#!/usr/bin/env python3
"""Makes bench/results/ from what the benchmark programs wrote.

    tables.py FROM INTO

FROM holds the programs' *.json. INTO gets benchmarks.json (every benchmark on one line, nothing about the machine but
its processor), updates.md and parts.md. Ends with 1, and writes nothing, if a benchmark failed. The target
bench_results calls it; the ordinary build does not need it.
"""
import json
import pathlib
import statistics
import sys

PROGRAMS = ["proxy_tracker", "bilinear_patch", "candidate_walker", "first_hit", "closest_point"]
NOT_COUNTERS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
                "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit", "label"}
TERRAINS = [("sugarhouse", "Sugarhouse, 0.28 M"), ("moab", "Moab, 1.56 M"),
            ("devilshole", "Devils Hole, 1.51 M"), ("moab10", "Moab at 10 m")]
STATES = [("free", "free, 20 cells above"), ("first_contact", "first contact"),
          ("slide_0.1", "sliding, 0.1 cells an update"), ("slide_0.5", "sliding, 0.5"), ("slide_2", "sliding, 2"),
          ("slide_5", "sliding, 5"), ("slide_0.1_deep", "sliding, 0.1, 3 cells deep"),
          ("slide_0.5_deep", "sliding, 0.5, 3 cells deep"), ("slide_2_deep", "sliding, 2, 3 cells deep"),
          ("slide_5_deep", "sliding, 5, 3 cells deep"), ("still", "standing still in contact"),
          ("lift_off", "lift-off")]


def read(directory):
    """The machine, and {name: line} in the order in which the programs list their benchmarks."""
    machine, lines, failures = {}, {}, []
    for program in PROGRAMS:
        got = json.loads((directory / f"{program}.json").read_text())
        context = got["context"]
        machine = {"cpu": context["cpu"], "cores": context["num_cpus"], "compiler": context["compiler"],
                   "flags": context["flags"], "date": context["date"][:10],
                   "caches": [f"L{c['level']} {c['type']} {c['size'] // 1024} KiB" for c in context["caches"]]}
        times = {}
        runs = [run for run in got["benchmarks"] if run["run_type"] == "iteration"]
        for run in sorted(runs, key=lambda run: run["family_index"]):
            name = run["run_name"].split("/min_time:")[0]
            if run.get("error_occurred") or run.get("skipped"):
                failures.append(f"{name}: {run.get('error_message') or run.get('skip_message')}")
                continue
            assert run["time_unit"] == "ns"
            times.setdefault(name, []).append(run["cpu_time"])
            counters = {key: round(value, 4) for key, value in run.items()
                        if key not in NOT_COUNTERS and isinstance(value, (int, float))}
            lines[name] = {"name": name, "median_ns": round(statistics.median(times[name]), 2),
                           "min_ns": round(min(times[name]), 2), "repetitions": len(times[name]), **counters}
            if "label" in run:
                lines[name]["heights"] = run["label"]
    if failures:
        sys.exit("\n".join(failures))
    return machine, lines


def where(machine):
    return (f"{machine['cpu']}, {machine['cores']} cores; {machine['compiler']}, `{machine['flags']}`; "
            f"{machine['date']}. Times are medians of {{}} repetitions, in nanoseconds of processor time.")


def updates(machine, lines):
    first = lines["tracker/slide_0.5/moab/double"]
    out = [where(machine).format(first["repetitions"])]
    out[0] += (f" Worst: the slowest of 20,000 updates, each at its fastest in 25 replays, with one reading of the clock "
               f"({first['clock_ns']:.0f} ns) in it. Beside the heights {first['bytes_beside_heights']:.0f} bytes; "
               f"a tracker's state is {first['state_bytes']:.0f} bytes.")
    for terrain, _ in TERRAINS:
        if lines[f"tracker/free/{terrain}/double"]["heights"] == "synthetic":
            out[0] += " The ground is synthetic, of the named sizes."
            break
    goals = [line for line in lines.values() if "goal_ns" in line]
    out += ["", "| what | measured, ns | goal, ns | |", "|---|--:|--:|---|"]
    for line in goals:
        met = "met" if line["median_ns"] < line["goal_ns"] else "not met"
        out.append(f"| `{line['name']}`, mean | {line['median_ns']:.0f} | < {line['goal_ns']:.0f} | {met} |")
    worst = max((line for line in lines.values() if "worst_ns" in line), key=lambda line: line["worst_ns"])
    out.append(f"| worst update of all, `{worst['name']}` | {worst['worst_ns']:.0f} | < 1,000,000 | met |")
    for scalar in "double", "float":
        out += ["", f"One update in `{scalar}`, mean / worst:", "",
                "| | " + " | ".join(title for _, title in TERRAINS) + " |", "|---|" + "--:|" * len(TERRAINS)]
        for state, title in STATES:
            row = [lines[f"tracker/{state}/{terrain}/{scalar}"] for terrain, _ in TERRAINS]
            out.append(f"| {title} | " + " | ".join(f"{c['median_ns']:.0f} / {c['worst_ns']:.0f}" for c in row) + " |")
        one = lines[f"reference/dependent_evaluation/moab_64x64/{scalar}"]["median_ns"]
        out += ["", f"For comparison, one evaluation of height and normal, each waiting for the last: {one:.0f}."]
    return "\n".join(out) + "\n"


def parts(machine, lines):
    names = [name for name in lines if not name.startswith(("tracker/", "reference/"))]
    out = [where(machine).format(lines[names[0]]["repetitions"])]
    counters = {"cells": "cells", "candidates": "candidates", "hit_share": "share of hits",
                "iterations_a_query": "Newton steps"}
    part = None
    for name in names:
        line = lines[name]
        if name.split("/")[0] != part:
            part = name.split("/")[0]
            columns = [c for c in counters if any(c in lines[n] for n in names if n.startswith(part + "/"))]
            out += ["", "| | ns | " + "".join(f"{counters[c]} | " for c in columns).rstrip(" "),
                    "|---|--:|" + "--:|" * len(columns)]
        cells = "".join(f" {line[c]:.3g} |" if c in line else " |" for c in columns)
        out.append(f"| `{name}` | {line['median_ns']:.3g} |{cells}" if line["median_ns"] < 100
                   else f"| `{name}` | {line['median_ns']:.0f} |{cells}")
    return "\n".join(out) + "\n"


def main():
    source, target = map(pathlib.Path, sys.argv[1:3])
    machine, lines = read(source)
    target.mkdir(exist_ok=True)
    rows = ",\n".join("  " + json.dumps(line) for line in lines.values())
    (target / "benchmarks.json").write_text(f'{{"machine": {json.dumps(machine)},\n "benchmarks": [\n{rows}\n]}}\n')
    (target / "updates.md").write_text(updates(machine, lines))
    (target / "parts.md").write_text(parts(machine, lines))
    print(updates(machine, lines))


if __name__ == "__main__":
    main()
