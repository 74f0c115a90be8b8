#!/usr/bin/env python3
"""Counts the instructions of an update, and guards them.

    cost.py check PROGRAM STORED     prints stored, now and the change; ends with 1 above +3 % or if a trace is missing
    cost.py update PROGRAM STORED    counts, and writes the figures of this compiler into STORED

PROGRAM is hfh_cost. Valgrind's callgrind counts what the replay executes and nothing else, so the same program gives
the same figures on every machine. Another compiler, or other flags, make another program: STORED has figures for each.
Where it has none, the figures are shown and not compared, and that is said. The C library could move the figures too,
because another version has other instructions, or picks others by the processor; a replay that calls it is told of.
Today's do not: floor and fma are instructions. The targets cost and cost_update call this.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ALLOWED = 3.0  # percent


def about(program):
    """Who built the program, and {trace: how many updates it has}."""
    said = {"trace": {}}
    for line in subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines():
        key, value = line.split(" ", 1)
        if key == "trace":
            name, updates = value.split(" ")
            said["trace"][name] = int(updates)
        else:
            said[key] = value
    return f"{said['compiler'].strip()}, {said['flags']}", said["trace"]


def instructions(profile):
    """{file of the program or of a library: instructions executed in it}, from what callgrind wrote."""
    names, counts, current, inclusive = {}, {}, None, False
    for line in profile.splitlines():
        if place := re.match(r"ob=(\(\d+\))(?: (.+))?$", line):
            current = names.setdefault(place[1], place[2])
        elif place := re.match(r"cob=(\(\d+\)) (.+)$", line):
            names.setdefault(place[1], place[2])
        elif line.startswith("calls="):
            inclusive = True  # the next line counts the callee, which has lines of its own
        elif cost := re.match(r"[+*-]?\d* (\d+)$", line):
            if not inclusive:
                counts[current] = counts.get(current, 0) + int(cost[1])
            inclusive = False
    return counts


def count(program, trace):
    """Instructions executed in the replay of one trace, by file."""
    with tempfile.TemporaryDirectory() as directory:
        profile = pathlib.Path(directory) / "callgrind.out"
        run = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no",
                              "--toggle-collect=hfh_cost_replay_*", f"--callgrind-out-file={profile}",
                              program, trace], capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"{trace} could not be counted:\n{run.stderr}")
        text = profile.read_text()
    counts = instructions(text)
    total = re.search(r"^totals: (\d+)$", text, re.MULTILINE)
    if not counts or total is None or sum(counts.values()) != int(total[1]):
        sys.exit(f"{trace}: what callgrind wrote cannot be read: its total is {total and total[1]}, "
                 f"its lines add up to {sum(counts.values())}")
    return counts


def measure(program):
    """Who built the program, {trace: instructions an update}, and lines about what ran outside the program."""
    if shutil.which("valgrind") is None:
        sys.exit("cost: valgrind is not installed, and it is what counts instructions (package valgrind).")
    build, traces = about(program)
    figures, notes = {}, []
    for trace, updates in traces.items():
        counts = count(program, trace)
        total = sum(counts.values())
        figures[trace] = round(total / updates, 1)
        for library, part in counts.items():
            if pathlib.Path(library).resolve() != pathlib.Path(program).resolve():
                notes.append(f"{trace}: {100 * part / total:.2f} % of it in {library}, "
                             "which may count otherwise on another machine")
    return build, figures, notes


def compare(stored, build, now):
    """Lines to print, and whether the change may go in."""
    if build not in stored:
        known = "; ".join(stored) or "none"
        return ([f"{trace:24} {figure:10.1f} instructions an update" for trace, figure in now.items()] +
                [f"NOT COMPARED: no figures are stored for {build}, only for: {known}. "
                 "The target cost_update stores them."], True)
    before = stored[build]
    lines, fine, cheaper = [f"{'instructions an update':24} {'stored':>10} {'now':>10}   change"], True, False
    for trace in dict.fromkeys([*before, *now]):
        if trace not in now or trace not in before:
            lines.append(f"{trace:24} is {'stored, but no longer counted' if trace in before else 'not stored'}")
            fine = False
            continue
        change = round(100 * (now[trace] / before[trace] - 1), 2) + 0.0  # no -0.00
        dearer = now[trace] > before[trace] * (100 + ALLOWED) / 100
        lines.append(f"{trace:24} {before[trace]:10.1f} {now[trace]:10.1f} {change:+7.2f} %" +
                     ("   too much" if dearer else ""))
        fine = fine and not dearer
        cheaper = cheaper or change < -ALLOWED
    lines.append(f"({build})")
    if not fine:
        lines.append(f"More than +{ALLOWED:g} %, or a trace without its figure. If that is meant, commit what the target "
                     "cost_update writes together with the change.")
    elif cheaper:
        lines.append("Cheaper than stored: commit what the target cost_update writes, so that it stays so.")
    return lines, fine


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("check", "update"):
        sys.exit(__doc__)
    program, file = sys.argv[2], pathlib.Path(sys.argv[3])
    stored = json.loads(file.read_text()) if file.exists() else {}
    build, now, notes = measure(program)
    lines, fine = compare(stored, build, now)
    print("\n".join(lines + notes))
    if sys.argv[1] == "check":
        sys.exit(0 if fine else 1)
    stored[build] = now
    file.write_text(json.dumps(dict(sorted(stored.items())), indent=2) + "\n")
    print(f"written: {file}")
    if others := [other for other in stored if other != build]:
        print("as they were: the figures of " + "; ".join(others))


if __name__ == "__main__":
    main()
