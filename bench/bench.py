#!/usr/bin/env python3
"""Runs the benchmarks, shows what they measured beside the record, and records.

    bench.py run DIRECTORY [--vast] PROGRAM...   runs each program; leaves what it measured in DIRECTORY
    bench.py show DIRECTORY RESULTS              prints the tables, beside what RESULTS has on record; fails if a goal is lost
    bench.py record DIRECTORY RESULTS            writes the tables and the figures behind them into RESULTS

hfh_goals is run five times and leaves goals.jsonl, a Google benchmark bench_NAME leaves NAME.json. README.md beside this
file says what fails when; goals/goals.toml has the goals. The targets bench, bench_full and bench_record call this.
"""
import datetime
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
RUNS = 5
SLACK = 0.1  # times of one run repeat to a few hundredths
REPETITIONS = ["--benchmark_repetitions=9", "--benchmark_enable_random_interleaving=true",
               "--benchmark_display_aggregates_only=true"]
PROGRAMS = ["proxy_tracker", "bilinear_patch", "candidate_walker", "first_hit", "closest_point", "pieces",
            "min_max_pyramid"]
# {what a program writes itself: the target that runs it}
PAGES = {"accuracy.json": "accuracy", "accuracy.md": "accuracy", "accuracy.png": "accuracy",
         "ball.md": "ball_feel", "ball_roughness.png": "ball_feel", "ball_steps.png": "ball_feel",
         "closed_loop.md": "closed_loop", "viewer.md": "viewer_figures"}


# Running.


def circumstances():
    """When, from which commit, and beside how much other work."""
    def git(*arguments):
        done = subprocess.run(["git", "-C", str(HERE), *arguments], capture_output=True, text=True)
        return done.stdout.strip() if done.returncode == 0 else ""
    commit = git("rev-parse", "--short", "HEAD") or "unknown"
    if git("status", "--porcelain", "--untracked-files=no"):
        commit += " with changes"
    return {"date": datetime.date.today().isoformat(), "commit": commit, "load": round(os.getloadavg()[0], 1),
            "cores": os.cpu_count()}


def run_goals(program, directory, vast):
    lines = []
    for run in range(1, RUNS + 1):
        print(f"{program.name}: run {run} of {RUNS}", flush=True)
        done = subprocess.run([program, *(["--vast"] if vast else [])], stdout=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"{program.name} ended with {done.returncode}: a wrong answer, or an update of 1 ms")
        lines += [{**json.loads(line), "run": run} for line in done.stdout.splitlines()]
    lines.insert(0, circumstances())
    (directory / "goals.jsonl").write_text("".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines))


def run_benchmark(program, directory):
    file = directory / f"{program.name.removeprefix('bench_')}.json"
    unfinished = file.with_suffix(".unfinished")
    done = subprocess.run([program, *REPETITIONS, f"--benchmark_out={unfinished}"])
    if done.returncode != 0:
        sys.exit(f"{program.name} ended with {done.returncode}")
    got = json.loads(unfinished.read_text())
    got["context"].update(circumstances())
    file.write_text(json.dumps(got))
    unfinished.unlink()


def run(directory, programs, vast):
    directory.mkdir(parents=True, exist_ok=True)
    for program in programs:
        if program.name == "hfh_goals":
            run_goals(program, directory, vast)
        else:
            run_benchmark(program, directory)


# The goals.


def read_goals():
    return tomllib.loads((HERE / "goals/goals.toml").read_text())["goal"]


def read_measured(lines):
    """What hfh_goals found: the machine, the median of all runs for each number and workload, and what was skipped."""
    about, *lines = lines
    lines = [dict(line) for line in lines]
    machine = {key: lines[0][key] for key in ("cpu", "last_cache", "compiler", "flags")}
    numbers, workloads, skipped = {}, {}, {}
    for line in lines:
        if "goal" in line:
            numbers.setdefault((line["goal"], line["figure"]), []).append(line)
        elif "workload" in line:
            workloads.setdefault((line["workload"], line["ground"], line["cells"]), []).append(line)
        elif "skipped" in line:
            skipped[line["skipped"]] = line["why"]

    def median(runs, key):
        values = [run[key] for run in runs]
        return None if None in values else statistics.median(values)

    def merged(runs):
        number = {"goal": runs[0]["goal"], "figure": runs[0]["figure"], "value": median(runs, "value"),
                  "runs": [run["value"] for run in runs], "note": runs[-1].get("note", "")}
        if "times_ns" in runs[0]:
            number["times_ns"] = [statistics.median(times) for times in zip(*(run["times_ns"] for run in runs))]
        return {**number, **about}

    return {"machine": machine,
            "numbers": {key: merged(runs) for key, runs in numbers.items()},
            "workloads": {key: {**runs[0], "mean_ns": median(runs, "mean_ns"), "worst_ns": median(runs, "worst_ns"),
                                **about} for key, runs in workloads.items()},
            "skipped": skipped}


def read_record(file):
    """What `goals_json` wrote; nothing if there is no such file."""
    if not file.exists():
        return {"machine": None, "numbers": {}, "workloads": {}, "skipped": {}}
    got = json.loads(file.read_text())
    return {"machine": got["machine"],
            "numbers": {(n["goal"], n["figure"]): n for n in got["numbers"]},
            "workloads": {(w["workload"], w["ground"], w["cells"]): w for w in got["workloads"]},
            "skipped": {}}


BETTER = {"at_most": (lambda value, bound: value <= bound, 1 + SLACK, "at most"),
          "below": (lambda value, bound: value < bound, 1 + SLACK, "below"),
          "at_least": (lambda value, bound: value >= bound, 1 - SLACK, "at least"),
          "more_than": (lambda value, bound: value > bound, 1 - SLACK, "more than")}


def sense(goal):
    """None: a figure to look at, without a bound."""
    return next((key for key in BETTER if key in goal), None)


def figures_of(goal):
    """The figures that are all shown, in order; none: of whatever was measured the worst is shown."""
    bound = goal.get(sense(goal))
    return list(bound) if isinstance(bound, dict) else goal.get("figures", [])


def bound_of(goal, figure):
    bound = goal[sense(goal)]
    return bound[figure] if isinstance(bound, dict) else bound


def met(goal, number, slack=False):
    if sense(goal) is None:
        return True
    holds, allowance, _ = BETTER[sense(goal)]
    bound = bound_of(goal, number["figure"])
    return number["value"] is not None and holds(number["value"], bound * (allowance if slack else 1))


def numbers_of(goal, measured):
    found = [n for (name, _), n in measured["numbers"].items() if name == goal["id"]]
    figures = figures_of(goal)
    return sorted((n for n in found if n["figure"] in figures), key=lambda n: figures.index(n["figure"])) if figures else found


def is_lost(goal, number, record, same_machine):
    """Whether the number fails here; see README.md, What fails."""
    if goal["kind"] == "count":
        return not met(goal, number)
    before = record["numbers"].get((number["goal"], number["figure"]))
    return same_machine and before is not None and met(goal, before) and not met(goal, number, slack=True)


def lost(goals, measured, record):
    same_machine = measured["machine"] == record["machine"]
    return [f"no longer met: {goal['what']}{': ' if number['figure'] else ''}{number['figure']}: "
            f"{text(number['value'])} {goal['unit']}"
            for goal in goals for number in numbers_of(goal, measured) if is_lost(goal, number, record, same_machine)]


def with_what_is_kept(measured, record):
    """The measured, and from a record of the same machine what this time was not measured."""
    if measured["machine"] != record["machine"]:
        return measured
    return {**measured,
            "numbers": {**{key: number for key, number in record["numbers"].items() if key not in measured["numbers"]},
                        **measured["numbers"]},
            "workloads": {**record["workloads"], **measured["workloads"]}}


# Tables of the goals.


def text(number, digits=3):
    if number is None:
        return "–"
    if 100 <= abs(number) < 1e6:
        return f"{number:.0f}"
    return f"{number:.{digits}g}"


def worst_of(goal, numbers):
    small_is_good = sense(goal) in ("at_most", "below")
    return (max if small_is_good else min)(numbers, key=lambda n: (n["value"] is None, n["value"] or 0))


def shown(goal, numbers):
    """The figures of a goal in one cell of the table."""
    if not numbers:
        return "not measured"
    unit = " " + goal["unit"] if goal["unit"] else ""
    if figures_of(goal):
        values = {n["figure"]: text(n["value"]) for n in numbers}
        return " / ".join(values.get(figure, "–") for figure in figures_of(goal)) + unit
    worst = worst_of(goal, numbers)
    where = f" ({worst['figure']})" if len(numbers) > 1 and worst["figure"] and worst["value"] != 0 else ""
    return text(worst["value"]) + unit + where


def bound_in_words(goal):
    if sense(goal) is None:
        return "none"
    bound = goal[sense(goal)]
    bounds = list(bound.values()) if isinstance(bound, dict) else [bound]
    if len(set(bounds)) == 1:
        bounds = bounds[:1]
    return BETTER[sense(goal)][2] + " " + " / ".join(text(b) for b in bounds)


def verdict(goal, numbers):
    if sense(goal) is None:
        return ""
    if not all(met(goal, n) for n in numbers):
        return "not met"
    if not numbers:
        return "not measured"
    return "met" if len(numbers) >= len(figures_of(goal)) else "met where measured"


def table(head, rows, right=()):
    lines = ["| " + " | ".join(head) + " |",
             "|" + "|".join("--:" if k in right else "---" for k in range(len(head))) + "|"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def goal_table(goals, measured, beside=None):
    """With a column of what `beside` has, if there is one."""
    rows = []
    for goal in goals:
        numbers = numbers_of(goal, measured)
        row = [goal["what"], shown(goal, numbers), bound_in_words(goal), verdict(goal, numbers)]
        if beside is not None:
            row.insert(2, shown(goal, numbers_of(goal, beside)))
        rows.append(row)
    head = ["what", "measured", "goal", "met"]
    if beside is not None:
        head.insert(2, "on record")
    return table(head, rows, right=range(1, len(head) - 1))


def of(circumstance):
    shared = f", load average {circumstance['load']:g} on {circumstance['cores']} cores" if "load" in circumstance else ""
    return f"{circumstance['date']}, commit {circumstance['commit']}{shared}"


def processor(machine):
    return f"{machine['cpu']} with a last cache of {machine['last_cache']}" if machine["last_cache"] else machine["cpu"]


def latest(measured):
    return max(measured["numbers"].values(), key=lambda n: n["date"])


def most_runs(measured):
    return max(len(n["runs"]) for n in measured["numbers"].values())


def workload_table(measured, source):
    lines = [w for w in measured["workloads"].values() if (w["source"] == "shared") == (source == "shared")]
    names = list(dict.fromkeys(w["workload"] for w in lines))
    grounds = list(dict.fromkeys((w["ground"], w["cells"]) for w in lines))
    rows = []
    for ground, cells in sorted(grounds, key=lambda g: g[1]):
        row = [f"{ground}, {text(cells / 1e6)} M cells"]
        for name in names:
            found = [w for w in lines if (w["workload"], w["ground"], w["cells"]) == (name, ground, cells)]
            row.append(f"{text(found[0]['mean_ns'])} / {text(found[0]['worst_ns'])}" if found else "–")
            if found and of(found[0]) != of(latest(measured)) and row[0].count("*") == 0:
                row[0] += f" *({of(found[0])})*"
        rows.append(row)
    return table(["ground", *names], rows, right=range(1, 1 + len(names)))


def detail_table(goals, measured):
    rows = []
    for goal in goals:
        for n in numbers_of(goal, measured):
            reference, ours = n.get("times_ns", (0, 0))
            unit, size = ("ms", 1e6) if reference >= 1e6 else ("ns", 1)
            notes = [part for part in (f"{text(reference / size)} against {text(ours / size)} {unit}" if ours else "", n["note"],
                                       of(n) if of(n) != of(latest(measured)) else "") if part]
            spread = f"{text(min(n['runs']))} to {text(max(n['runs']))}" if len(set(n["runs"])) > 1 else ""
            if len(n["runs"]) < most_runs(measured):
                spread += f"{', ' if spread else ''}{len(n['runs'])} run{'s' if len(n['runs']) > 1 else ''}"
            if spread or notes:
                rows.append([goal["id"], n["figure"], text(n["value"]), spread, "; ".join(notes)])
    return table(["goal", "figure", "median", "of the runs", "made of"], rows, right=(2, 3))


SHARED = "Over terrain of `../shared/data`, which a clone does not have"


def by_terrain(goals):
    return [g for g in goals if not g.get("shared")], [g for g in goals if g.get("shared")]


def goals_page(goals, measured):
    machine = measured["machine"]
    of_clone, of_shared = by_terrain(goals)
    out = [f"{processor(machine)}, one core; {machine['compiler']}, `{machine['flags']}`; {of(latest(measured))}. Medians of "
           f"{most_runs(measured)} runs, or of fewer where that is said; `double` where nothing else is said; subject and reference in turn, in slices, in one process. "
           "A load above 1 is other work on the same machine: times and worst updates are then longer than they are alone.",
           "", "Anyone can measure these with a clone, `cmake --build build --target bench`:", "",
           *goal_table(of_clone, measured)]
    if any(numbers_of(goal, measured) for goal in of_shared):
        out += ["", f"{SHARED}:", "", *goal_table(of_shared, measured)]
    out += ["", "Why the goals are where they are:", ""]
    out += [f"- {goal['what']}{', on shared terrain' if goal.get('shared') else ''}: {goal['why']}" for goal in goals]
    out += ["", "One update, nanoseconds, mean / worst of all by replay:", "", *workload_table(measured, "clone")]
    if any(w["source"] == "shared" for w in measured["workloads"].values()):
        out += ["", f"{SHARED}:", "", *workload_table(measured, "shared")]
    out += ["", "What the figures are made of:", "", *detail_table(goals, measured)]
    return "\n".join(out) + "\n"


def goals_json(measured):
    def lines(entries):
        return ",\n".join("  " + json.dumps(entry, ensure_ascii=False) for entry in entries)
    return (f'{{"machine": {json.dumps(measured["machine"])},\n "numbers": [\n{lines(measured["numbers"].values())}\n ],\n'
            f' "workloads": [\n{lines(measured["workloads"].values())}\n ]}}\n')


def goals_to_look_at(goals, measured, record):
    """What `show` prints."""
    out = [f"{processor(measured['machine'])}, {measured['machine']['compiler']}; {of(latest(measured))}", ""]
    same_machine = measured["machine"] == record["machine"]
    beside = record if record["machine"] else None
    of_clone, of_shared = by_terrain(goals)
    out += goal_table(of_clone, measured, beside)
    if any(numbers_of(goal, measured) for goal in of_shared):
        out += ["", f"{SHARED}:", "", *goal_table(of_shared, measured, beside)]
    out += ["", *(f"skipped: {what}; {why}" for what, why in measured["skipped"].items())]
    if record["machine"] is None:
        out.append("Nothing is on record.")
    elif not same_machine:
        out.append(f"The record is of another machine ({processor(record['machine'])}, {record['machine']['compiler']}, "
                   f"`{record['machine']['flags']}`): ratios may be compared, times may not, and neither fails.")
    return "\n".join(out)


# Tables of the Google benchmarks.

TITLES = {"spanish_peaks": "Spanish Peaks, 0.09 M", "hills_0.28M": "hills, 0.28 M", "hills_1.56M": "hills, 1.56 M",
          "spanish_peaks_10m": "Spanish Peaks at 10 m", "big_tujunga": "Big Tujunga, 0.28 M",
          "sangre_de_cristo": "Sangre de Cristo, 1.56 M", "trinidad": "Trinidad, 1.51 M",
          "sangre_de_cristo_10m": "Sangre de Cristo at 10 m"}
STATES = [("free", "free, 20 cells above"), ("first_contact", "first contact"),
          ("slide_0.1", "sliding, 0.1 cells an update"), ("slide_0.5", "sliding, 0.5"), ("slide_2", "sliding, 2"),
          ("slide_5", "sliding, 5"), ("slide_0.1_deep", "sliding, 0.1, 3 cells deep"),
          ("slide_0.5_deep", "sliding, 0.5, 3 cells deep"), ("slide_2_deep", "sliding, 2, 3 cells deep"),
          ("slide_5_deep", "sliding, 5, 3 cells deep"), ("still", "standing still in contact"),
          ("lift_off", "lift-off")]
COLUMNS = {"cells": "cells", "candidates": "candidates", "hit_share": "share of hits",
           "iterations_a_query": "Newton steps", "bytes_a_sample": "bytes a sample",
           "of_read_speed": "of the speed of reading"}
NOT_COUNTERS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
                "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit", "label"}


def read_benchmarks(directory):
    """The machine, when and how each program was run, and {name: line} in the order in which the programs list them."""
    found = {"machine": None, "programs": {}, "lines": {}}
    for program in PROGRAMS:
        if not (directory / f"{program}.json").exists():
            continue
        got = json.loads((directory / f"{program}.json").read_text())
        context = got["context"]
        found["machine"] = {key: context[key] for key in ("cpu", "last_cache", "compiler", "flags")}
        times = {}
        runs = [run for run in got["benchmarks"] if run["run_type"] == "iteration"]
        for run in sorted(runs, key=lambda run: run["family_index"]):
            name = run["run_name"].split("/min_time:")[0]
            assert run["time_unit"] == "ns"
            # Those with a clock of their own tell its time as real time.
            own_clock = run["run_name"].endswith("/manual_time")
            times.setdefault(name, []).append(run["real_time" if own_clock else "cpu_time"])
            counters = {key: round(value, 4) for key, value in run.items()
                        if key not in NOT_COUNTERS and isinstance(value, (int, float))}
            found["lines"][name] = {"name": name, "program": program,
                                    "median_ns": round(statistics.median(times[name]), 2),
                                    "min_ns": round(min(times[name]), 2), **counters}
            if "label" in run:
                found["lines"][name]["source"] = run["label"]
        found["programs"][program] = {**{key: context[key] for key in ("date", "commit", "load", "cores")},
                                      "repetitions": max(len(all_times) for all_times in times.values())}
    return found


def read_benchmark_record(file):
    if not file.exists():
        return {"machine": None, "programs": {}, "lines": {}}
    got = json.loads(file.read_text())
    return {"machine": got["machine"], "programs": got["programs"],
            "lines": {line["name"]: line for line in got["benchmarks"]}}


def benchmarks_and_kept(found, record):
    """The programs that were run, and from a record of the same machine those that were not."""
    if found["machine"] != record["machine"]:
        return found
    kept = {name: line for name, line in record["lines"].items() if line["program"] not in found["programs"]}
    return {**found, "programs": {**record["programs"], **found["programs"]}, "lines": {**kept, **found["lines"]}}


def heading(found, program):
    machine, ran = found["machine"], found["programs"][program]
    return (f"{processor(machine)}; {machine['compiler']}, `{machine['flags']}`; {of(ran)}. Times are medians of "
            f"{ran['repetitions']} repetitions, in nanoseconds of processor time.")


def updates_page(found):
    lines = found["lines"]
    first = next(line for name, line in lines.items() if name.startswith("tracker/"))
    out = [heading(found, "proxy_tracker") +
           f" Worst: the slowest of 20,000 updates, each at its fastest in 25 replays, with one reading of the clock "
           f"({first['clock_ns']:.0f} ns) in it. Beside the heights {first['bytes_beside_heights']:.0f} bytes; "
           f"a tracker's state is {first['state_bytes']:.0f} bytes."]
    for shared in False, True:
        for scalar in "double", "float":
            terrains = [name for name in TITLES
                        if (line := lines.get(f"tracker/free/{name}/{scalar}")) and (line["source"] == "shared") == shared]
            if not terrains:
                continue
            out += ["", f"{SHARED + ': one' if shared else 'One'} update in `{scalar}`, mean / worst:", ""]
            rows = []
            for state, title in STATES:
                cells = [lines[f"tracker/{state}/{terrain}/{scalar}"] for terrain in terrains]
                rows.append([title, *(f"{c['median_ns']:.0f} / {c['worst_ns']:.0f}" for c in cells)])
            out += table(["", *(TITLES[name] for name in terrains)], rows, right=range(1, 1 + len(terrains)))
            if not shared:
                one = lines[f"reference/dependent_evaluation/hills_64x64/{scalar}"]["median_ns"]
                out += ["", f"For comparison, one evaluation of height and normal, each waiting for the last: {one:.0f}."]
    return "\n".join(out) + "\n"


def parts_page(found):
    out = ["Names in italics are over terrain of `../shared/data`, which a clone does not have."]
    for program in PROGRAMS:
        here = [line for line in found["lines"].values() if line["program"] == program]
        if program == "proxy_tracker" or not here:
            continue
        columns = [c for c in COLUMNS if any(c in line for line in here)]
        rows = []
        for line in here:
            mark = "*" if line.get("source") == "shared" else ""
            rows.append([f"{mark}`{line['name']}`{mark}", text(line["median_ns"]),
                         *(f"{line[c]:.3g}" if c in line else "" for c in columns)])
        out += ["", heading(found, program), "",
                *table(["", "ns", *(COLUMNS[c] for c in columns)], rows, right=range(1, 2 + len(columns)))]
    return "\n".join(out) + "\n"


def benchmark_pages(found):
    """{file: text}."""
    pages = {}
    if "proxy_tracker" in found["programs"]:
        pages["updates.md"] = updates_page(found)
    if any(program != "proxy_tracker" for program in found["programs"]):
        pages["parts.md"] = parts_page(found)
    return pages


def benchmarks_json(found):
    rows = ",\n".join("  " + json.dumps(line) for line in found["lines"].values())
    return (f'{{"machine": {json.dumps(found["machine"])},\n "programs": {json.dumps(found["programs"])},\n'
            f' "benchmarks": [\n{rows}\n]}}\n')


# The commands.


def read_lines(file):
    return [json.loads(line) for line in file.read_text().splitlines()]


def show(directory, results):
    fine = True
    if (directory / "goals.jsonl").exists():
        goals, measured = read_goals(), read_measured(read_lines(directory / "goals.jsonl"))
        record = read_record(results / "goals.json")
        print(goals_to_look_at(goals, measured, record))
        for line in lost(goals, measured, record):
            print(line, file=sys.stderr)
            fine = False
    for page in benchmark_pages(read_benchmarks(directory)).values():
        print("", page, sep="\n")
    return fine


def record(directory, results):
    """Writes what there is, and says what there is not. A record of lost goals is written all the same: it is what was
    measured, and the change is there to be seen before it is committed."""
    results.mkdir(exist_ok=True)
    fine = True
    if (directory / "goals.jsonl").exists():
        goals, measured = read_goals(), read_measured(read_lines(directory / "goals.jsonl"))
        before = read_record(results / "goals.json")
        for line in lost(goals, measured, before):
            print(line, file=sys.stderr)
            fine = False
        measured = with_what_is_kept(measured, before)
        (results / "goals.json").write_text(goals_json(measured))
        (results / "goals.md").write_text(goals_page(goals, measured))
        print("written: goals.json, goals.md")
    else:
        print("as they were: goals.json, goals.md; the target bench measures them")
    found = read_benchmarks(directory)
    if found["programs"]:
        found = benchmarks_and_kept(found, read_benchmark_record(results / "benchmarks.json"))
        (results / "benchmarks.json").write_text(benchmarks_json(found))
        for page, content in benchmark_pages(found).items():
            (results / page).write_text(content)
        print("written: benchmarks.json,", ", ".join(benchmark_pages(found)))
    if missing := [program for program in PROGRAMS if not (directory / f"{program}.json").exists()]:
        print(f"not measured: {', '.join(missing)}; the target bench_full does it")
    for page, target in PAGES.items():
        if (directory / page).exists():
            shutil.copyfile(directory / page, results / page)
            print(f"written: {page}")
        else:
            print(f"as it was: {page}; the target {target} measures it")
    return fine


def main():
    command, *arguments = sys.argv[1:] or [""]
    vast = "--vast" in arguments
    paths = [pathlib.Path(a) for a in arguments if a != "--vast"]
    if command == "run" and len(paths) >= 2:
        run(paths[0], paths[1:], vast)
    elif command in ("show", "record") and len(paths) == 2 and not vast:
        sys.exit(0 if {"show": show, "record": record}[command](*paths) else 1)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
