#!/usr/bin/env python3
"""Counts the instructions of an update, and guards them.

    cost.py check PROGRAM STORED     prints stored, now and the change; ends with 1 above +3 % or if a trace is missing
    cost.py update PROGRAM STORED    counts and writes STORED

PROGRAM is hfh_cost. Valgrind's callgrind counts what the replay executes and nothing else, so the same program gives
the same figures on every machine. Another compiler makes another program: its figures are shown and not compared,
and that is said. The targets cost and cost_update call this.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ALLOWED = 3.0  # percent


def about(program):
    """What the program says of itself, and the names of its traces."""
    said = {"trace": []}
    for line in subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines():
        key, value = line.split(" ", 1)
        if key == "trace":
            said["trace"].append(value)
        else:
            said[key] = value
    return said


def count(program, trace):
    """Instructions executed in the replay of one trace."""
    with tempfile.TemporaryDirectory() as directory:
        profile = pathlib.Path(directory) / "callgrind.out"
        run = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no",
                              "--toggle-collect=hfh_cost_replay_*", f"--callgrind-out-file={profile}",
                              program, trace], capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"{trace} could not be counted:\n{run.stderr}")
        totals = [line for line in profile.read_text().splitlines() if line.startswith("totals:")]
    counted = int(totals[0].split()[1]) if totals else 0
    if counted == 0:
        sys.exit(f"{trace}: callgrind saw no instruction of the replay")
    return counted


def measure(program):
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is needed to count instructions, but is not installed.")
    said = about(program)
    updates = int(said["updates"])
    figures = {trace: round(count(program, trace) / updates, 1) for trace in said["trace"]}
    return {"compiler": said["compiler"], "flags": said["flags"], "instructions_per_update": figures}


def compare(stored, now):
    """Lines to print, and whether the change may go in."""
    before, after = stored["instructions_per_update"], now["instructions_per_update"]
    different = [f"stored for {stored[key]}, this is {now[key]}" for key in ("compiler", "flags")
                 if stored[key] != now[key]]
    if different:
        return ([f"{trace:24} {figure:10.1f} instructions an update" for trace, figure in after.items()] +
                ["not compared: " + "; ".join(different)], True)
    lines, fine, cheaper = [f"{'instructions an update':24} {'stored':>10} {'now':>10}   change"], True, False
    for trace in dict.fromkeys([*before, *after]):
        if trace not in after or trace not in before:
            lines.append(f"{trace:24} is {'stored, but no longer counted' if trace in before else 'not stored'}")
            fine = False
            continue
        change = round(100 * (after[trace] / before[trace] - 1), 2) + 0.0  # no -0.00
        dearer = after[trace] > before[trace] * (100 + ALLOWED) / 100
        lines.append(f"{trace:24} {before[trace]:10.1f} {after[trace]:10.1f} {change:+7.2f} %" +
                     ("   too much" if dearer else ""))
        fine = fine and not dearer
        cheaper = cheaper or change < -ALLOWED
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
    if sys.argv[1] == "check" and not file.exists():
        sys.exit(f"{file} does not exist; the target cost_update writes it.")
    now = measure(program)
    fine = True
    if file.exists():
        lines, fine = compare(json.loads(file.read_text()), now)
        print("\n".join(lines))
    if sys.argv[1] == "update":
        file.write_text(json.dumps(now, indent=2) + "\n")
        print(f"written: {file}")
        return
    sys.exit(0 if fine else 1)


if __name__ == "__main__":
    main()
