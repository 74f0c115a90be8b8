#!/usr/bin/env python3
"""The verdicts of cost.py, on figures made up for the purpose."""
import unittest

import cost


def figures(compiler="GCC 12.2.0", flags="-O3", **traces):
    return {"compiler": compiler, "flags": flags, "instructions_per_update": traces}


class Verdicts(unittest.TestCase):
    def verdict(self, stored, now):
        lines, fine = cost.compare(stored, now)
        return "\n".join(lines), fine

    def test_the_same_passes(self):
        text, fine = self.verdict(figures(free=100.0), figures(free=100.0))
        self.assertTrue(fine)
        self.assertIn("+0.00 %", text)

    def test_three_percent_passes_and_more_fails(self):
        self.assertTrue(self.verdict(figures(free=100.0, still=50.0), figures(free=103.0, still=50.0))[1])
        text, fine = self.verdict(figures(free=100.0, still=50.0), figures(free=103.1, still=50.0))
        self.assertFalse(fine)
        self.assertIn("+3.10 %   too much", text)

    def test_one_gain_does_not_pay_for_another_loss(self):
        self.assertFalse(self.verdict(figures(free=100.0, still=100.0), figures(free=50.0, still=110.0))[1])

    def test_a_gain_passes_and_asks_to_be_stored(self):
        text, fine = self.verdict(figures(free=100.0), figures(free=80.0))
        self.assertTrue(fine)
        self.assertIn("commit what the target cost_update writes", text)

    def test_a_trace_missing_on_either_side_fails(self):
        self.assertFalse(self.verdict(figures(free=100.0, still=50.0), figures(free=100.0))[1])
        self.assertFalse(self.verdict(figures(free=100.0), figures(free=100.0, still=50.0))[1])

    def test_another_compiler_or_flags_are_not_compared_and_that_is_said(self):
        for other in figures("GCC 13.2.0", free=900.0), figures(flags="-O2", free=900.0):
            text, fine = self.verdict(figures(free=100.0), other)
            self.assertTrue(fine)
            self.assertIn("not compared: stored for", text)
            self.assertIn("900.0", text)


if __name__ == "__main__":
    unittest.main()
