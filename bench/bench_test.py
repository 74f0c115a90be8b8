#!/usr/bin/env python3
"""What bench.py makes of figures made up for the purpose, and when it fails."""
import contextlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import bench

HERE = {"cpu": "a \"processor\" of 2 \\ 3 GHz", "last_cache": "8192 KiB", "compiler": "a compiler", "flags": "-O3"}
ELSEWHERE = {**HERE, "cpu": "another processor"}
ABOUT = {"date": "2026-01-02", "commit": "abc1234", "load": 0.3, "cores": 2}
RATIO = {"id": "speed", "what": "speed", "kind": "ratio", "unit": "×", "at_least": 5, "why": "because"}
TIME = {"id": "worst", "what": "worst", "kind": "time", "unit": "µs", "at_most": {"near": 10, "far": 20}, "why": "because"}
COUNT = {"id": "bytes", "what": "bytes", "kind": "count", "unit": "bytes", "at_most": 0, "why": "because"}


def measured(machine=HERE, skipped=None, **runs):
    """speed=[6, 7] for a goal's only figure; worst={"near": [9], "far": [12]} for several."""
    lines = [ABOUT, {**machine, "run": 1}]
    for goal, figures in runs.items():
        for figure, values in (figures if isinstance(figures, dict) else {"": figures}).items():
            lines += [{"goal": goal, "figure": figure, "value": value, "run": k + 1} for k, value in enumerate(values)]
    lines += [{"skipped": what, "why": why} for what, why in (skipped or {}).items()]
    return bench.read_measured(lines)


def failures(now, record, *goals):
    return bench.lost(goals, now, record)


class Figures(unittest.TestCase):
    def test_a_figure_is_the_median_of_its_runs(self):
        number = measured(speed=[9, 1, 6, 7, 2])["numbers"]["speed", ""]
        self.assertEqual(number["value"], 6)
        self.assertEqual(number["runs"], [9, 1, 6, 7, 2])

    def test_what_is_written_is_read_again(self):
        now = measured(speed=[6], worst={"near": [9], "far": [12]})
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "goals.json"
            file.write_text(bench.goals_json(now))
            again = bench.read_record(file)
        self.assertEqual(again["machine"], HERE)
        self.assertEqual(again["numbers"], now["numbers"])

    def test_no_file_is_an_empty_record(self):
        self.assertEqual(bench.read_record(pathlib.Path("none.json"))["numbers"], {})


class Verdicts(unittest.TestCase):
    def test_a_goal_that_was_never_met_cannot_be_lost(self):
        self.assertFalse(failures(measured(speed=[3]), measured(speed=[4]), RATIO))
        self.assertFalse(failures(measured(speed=[3]), bench.read_record(pathlib.Path("none.json")), RATIO))

    def test_a_goal_that_was_met_is_lost_beyond_the_noise(self):
        before = measured(speed=[5.1])
        self.assertFalse(failures(measured(speed=[4.6]), before, RATIO))
        self.assertEqual(failures(measured(speed=[4.4]), before, RATIO), ["no longer met: speed: 4.4 ×"])

    def test_each_figure_is_held_by_itself(self):
        before = measured(worst={"near": [9], "far": [30]})
        self.assertEqual(failures(measured(worst={"near": [12], "far": [40]}), before, TIME),
                         ["no longer met: worst: near: 12 µs"])

    def test_ratios_and_times_of_another_machine_hold_nothing(self):
        for other in ELSEWHERE, {**HERE, "last_cache": "4096 KiB"}, {**HERE, "flags": "-O2"}, {**HERE, "compiler": "another"}:
            before = measured(speed=[6], worst={"near": [9], "far": [12]})
            self.assertFalse(failures(measured(other, speed=[1], worst={"near": [99], "far": [99]}), before, RATIO, TIME))

    def test_a_count_has_no_noise_and_fails_everywhere(self):
        self.assertTrue(failures(measured(ELSEWHERE, bytes=[1]), measured(bytes=[0]), COUNT))
        self.assertFalse(failures(measured(ELSEWHERE, bytes=[0]), measured(bytes=[0]), COUNT))

    def test_what_is_not_measured_is_not_lost(self):
        self.assertFalse(failures(measured(speed=[6]), measured(bytes=[0], speed=[6]), RATIO, COUNT))

    def test_a_number_that_is_none_is_not_met(self):
        self.assertEqual(len(failures(measured(speed=[None]), measured(speed=[6]), RATIO)), 1)


class Tables(unittest.TestCase):
    def test_met_not_met_and_not_measured(self):
        out = "\n".join(bench.goal_table([RATIO, TIME, COUNT], measured(speed=[6], worst={"near": [9], "far": [21]})))
        self.assertIn("| speed | 6 × | at least 5 | met |", out)
        self.assertIn("| worst | 9 / 21 µs | at most 10 / 20 | not met |", out)
        self.assertIn("| bytes | not measured | at most 0 | not measured |", out)

    def test_a_figure_without_a_bound_is_shown_and_cannot_fail(self):
        look = {"id": "look", "what": "look", "kind": "ratio", "unit": "×", "figures": ["a", "b"], "why": "None."}
        now = measured(look={"b": [2], "a": [1]})
        self.assertIn("| look | 1 / 2 × | none |  |", "\n".join(bench.goal_table([look], now)))
        self.assertFalse(failures(measured(look={"a": [9], "b": [9]}), now, look))

    def test_of_several_figures_with_one_bound_the_worst_is_shown(self):
        out = "\n".join(bench.goal_table([RATIO], measured(speed={"a": [9], "b": [4], "c": [7]})))
        self.assertIn("| speed | 4 × (b) | at least 5 | not met |", out)

    def test_on_another_machine_the_record_stands_beside_and_that_is_said(self):
        out = bench.goals_to_look_at([RATIO], measured(ELSEWHERE, speed=[6], skipped={"moon": "it is not there"}),
                                     measured(speed=[7]))
        self.assertIn("| speed | 6 × | 7 × | at least 5 | met |", out)
        self.assertIn("The record is of another machine", out)
        self.assertIn("skipped: moon; it is not there", out)

    def test_shared_terrain_has_a_table_of_its_own(self):
        page = bench.goals_page([RATIO, {**TIME, "shared": True}], measured(speed=[6], worst={"near": [9], "far": [9]}))
        self.assertLess(page.index("| speed |"), page.index("a clone does not have"))
        self.assertLess(page.index("a clone does not have"), page.index("| worst |"))
        self.assertNotIn("a clone does not have",
                         bench.goals_page([RATIO, {**TIME, "shared": True}], measured(speed=[6])))


class Recording(unittest.TestCase):
    def test_what_was_not_measured_is_kept_with_its_date_from_the_same_machine_only(self):
        before = measured(speed=[6], bytes=[0])
        before["numbers"]["speed", ""]["date"] = "2025-01-01"
        kept = bench.with_what_is_kept(measured(bytes=[0]), before)
        self.assertEqual(kept["numbers"]["speed", ""]["date"], "2025-01-01")
        self.assertNotIn(("speed", ""), bench.with_what_is_kept(measured(ELSEWHERE, bytes=[0]), before)["numbers"])

    def test_only_record_writes_and_only_into_results(self):
        goal = bench.read_goals()[0]
        figures = bench.figures_of(goal)
        with tempfile.TemporaryDirectory() as directory:
            source, results = pathlib.Path(directory) / "measured", pathlib.Path(directory) / "results"
            source.mkdir()
            results.mkdir()
            lines = [ABOUT, {**HERE, "run": 1},
                     *({"goal": goal["id"], "figure": figure, "value": 0, "run": 1} for figure in figures)]
            (source / "goals.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
            with contextlib.redirect_stdout(io.StringIO()) as said:
                self.assertTrue(bench.show(source, results))
                self.assertEqual(list(results.iterdir()), [])
                self.assertTrue(bench.record(source, results))
            self.assertEqual({file.name for file in results.iterdir()}, {"goals.json", "goals.md"})
            self.assertIn("as it was: closed_loop.md", said.getvalue())

    def test_a_program_that_fails_leaves_no_figures(self):
        with tempfile.TemporaryDirectory() as directory:
            program = pathlib.Path(directory) / "hfh_goals"
            program.write_text("#!/bin/sh\nexit 1\n")
            program.chmod(0o755)
            ran = subprocess.run([sys.executable, bench.__file__, "run", directory, program], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 1)
            self.assertIn("a wrong answer", ran.stderr)
            self.assertFalse((pathlib.Path(directory) / "goals.jsonl").exists())


class Benchmarks(unittest.TestCase):
    CONTEXT = {**HERE, **ABOUT}

    def found(self, program, runs):
        """What one program left: name, source, nanoseconds of each repetition, counters."""
        benchmarks = [{"run_name": f"{name}/min_time:0.050", "run_type": "iteration", "family_index": k,
                       "time_unit": "ns", "cpu_time": time, "real_time": 2 * time, "label": source, **counters}
                      for k, (name, source, times, counters) in enumerate(runs) for time in times]
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / f"{program}.json"
            file.write_text(json.dumps({"context": self.CONTEXT, "benchmarks": benchmarks}))
            return bench.read_benchmarks(pathlib.Path(directory))

    def trackers(self, **terrains):
        counters = {"worst_ns": 900.0, "clock_ns": 30.0, "bytes_beside_heights": 0.0, "state_bytes": 88.0}
        runs = [(f"tracker/{state}/{terrain}/double", source, [100, 300, 200], counters)
                for state, _ in bench.STATES for terrain, source in terrains.items()]
        runs.append(("reference/dependent_evaluation/hills_64x64/double", "generated", [40], {}))
        return self.found("proxy_tracker", runs)

    def test_updates_of_a_clone_and_of_shared_terrain_have_tables_of_their_own(self):
        page = bench.updates_page(self.trackers(spanish_peaks="bundled", trinidad="shared"))
        self.assertIn("| sliding, 0.5 | 200 / 900 |", page)
        self.assertLess(page.index("Spanish Peaks"), page.index("a clone does not have"))
        self.assertLess(page.index("a clone does not have"), page.index("Trinidad"))
        self.assertNotIn("a clone does not have", bench.updates_page(self.trackers(spanish_peaks="bundled")))

    def test_parts_are_listed_with_their_counters(self):
        page = bench.parts_page(self.found("first_hit", [("first_hit/a", "generated", [50], {"cells": 3.0}),
                                                         ("first_hit/b", "shared", [60], {"cells": 4.0})]))
        self.assertIn("| `first_hit/a` | 50 | 3 |", page)
        self.assertIn("| *`first_hit/b`* | 60 | 4 |", page)

    def test_a_program_that_was_not_run_keeps_its_record_of_the_same_machine(self):
        record = self.found("first_hit", [("first_hit/a", "generated", [50], {})])
        now = self.found("closest_point", [("closest_point/a", "generated", [60], {})])
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "benchmarks.json"
            file.write_text(bench.benchmarks_json(record))
            record = bench.read_benchmark_record(file)
        self.assertEqual(set(bench.benchmarks_and_kept(now, record)["lines"]), {"first_hit/a", "closest_point/a"})
        record["machine"] = ELSEWHERE
        self.assertEqual(set(bench.benchmarks_and_kept(now, record)["lines"]), {"closest_point/a"})


class Goals(unittest.TestCase):
    def test_each_goal_is_named_once_and_says_why(self):
        goals = bench.read_goals()
        self.assertEqual(len({goal["id"] for goal in goals}), len(goals))
        for goal in goals:
            self.assertIn(goal["kind"], ("ratio", "time", "count", "force"))
            self.assertEqual(sum(key in goal for key in [*bench.BETTER, "figures"]), 1, goal["id"])
            self.assertTrue(goal["why"].endswith("."), goal["id"])

    def test_every_goal_is_one_that_the_program_measures(self):
        sources = "".join(file.read_text() for file in (bench.HERE / "goals").glob("*.cpp"))
        for goal in bench.read_goals():
            self.assertRegex(sources, re.escape('"' + goal["id"].removesuffix("_shared") + '"'), goal["id"])


if __name__ == "__main__":
    unittest.main()
