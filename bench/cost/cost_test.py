#!/usr/bin/env python3
"""The verdicts of cost.py, on figures made up for the purpose."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import cost

GCC = "GCC 12.2.0, -O3"
PROFILE = """\
version: 1
positions: line
events: Ir

ob=(8) /build/hfh_cost
fl=(1) main.cpp
fn=(1) replay
16 1000
cfn=(2) descend
calls=20 4
+3 900
* 24
cob=(3) /lib/libm.so.6
cfi=(4) s_sin.c
cfn=(9) sin
calls=7 10
-2 70

fn=(2)
0 900

ob=(3)
fl=(4)
fn=(9)
10 70

totals: 1994
"""


class Verdicts(unittest.TestCase):
    def verdict(self, before, now, build=GCC):
        lines, fine = cost.compare({GCC: before}, build, now)
        return "\n".join(lines), fine

    def test_the_same_passes(self):
        text, fine = self.verdict({"free": 100.0}, {"free": 100.0})
        self.assertTrue(fine)
        self.assertIn("+0.00 %", text)

    def test_three_percent_passes_and_more_fails(self):
        self.assertTrue(self.verdict({"free": 100.0, "still": 50.0}, {"free": 103.0, "still": 50.0})[1])
        text, fine = self.verdict({"free": 100.0, "still": 50.0}, {"free": 103.1, "still": 50.0})
        self.assertFalse(fine)
        self.assertIn("+3.10 %   too much", text)

    def test_one_gain_does_not_pay_for_another_loss(self):
        self.assertFalse(self.verdict({"free": 100.0, "still": 100.0}, {"free": 50.0, "still": 110.0})[1])

    def test_a_gain_passes_and_asks_to_be_stored(self):
        text, fine = self.verdict({"free": 100.0}, {"free": 80.0})
        self.assertTrue(fine)
        self.assertIn("commit what the target cost_update writes", text)

    def test_a_trace_missing_on_either_side_fails(self):
        self.assertFalse(self.verdict({"free": 100.0, "still": 50.0}, {"free": 100.0})[1])
        self.assertFalse(self.verdict({"free": 100.0}, {"free": 100.0, "still": 50.0})[1])

    def test_another_compiler_or_flags_are_not_compared_and_that_is_said(self):
        for other in "GCC 13.2.0, -O3", "GCC 12.2.0, -O2":
            text, fine = self.verdict({"free": 100.0}, {"free": 900.0}, other)
            self.assertTrue(fine)
            self.assertIn(f"NOT COMPARED: no figures are stored for {other}, only for: {GCC}", text)
            self.assertIn("900.0", text)


class Counting(unittest.TestCase):
    def test_every_instruction_is_counted_once_and_where_it_lies(self):
        self.assertEqual(cost.instructions(PROFILE), {"/build/hfh_cost": 1000 + 24 + 900, "/lib/libm.so.6": 70})

    def test_without_valgrind_it_says_so_and_fails(self):
        with tempfile.TemporaryDirectory() as empty:
            run = subprocess.run([sys.executable, cost.__file__, "check", sys.executable,
                                  str(pathlib.Path(empty) / "none.json")],
                                 env={**os.environ, "PATH": empty}, capture_output=True, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("valgrind is not installed", run.stderr)


if __name__ == "__main__":
    unittest.main()
