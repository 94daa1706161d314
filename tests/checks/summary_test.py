"""tests/summary.py: what is skipped is not counted as passed, and its reason is told."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from summary import summary  # noqa: E402

# The format that CMake 3.25 writes.
RESULTS = """<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="Linux-c++" tests="6" failures="1" disabled="0" skipped="3">
  <testcase name="a" classname="a" time="0.01" status="run"><system-out>ok</system-out></testcase>
  <testcase name="b" classname="b" time="0.01" status="fail">
    <failure message=""/><system-out>expected 1</system-out></testcase>
  <testcase name="check.firmware" classname="c" time="0.01" status="notrun">
    <skipped message="SKIP_RETURN_CODE=77"/>
    <system-out>skipped: no arm-none-eabi-gcc</system-out></testcase>
  <testcase name="hw.One" classname="c" time="0.01" status="notrun">
    <skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>
    <system-out>recordings_test.cpp:94: Skipped
people.csv is not here

[  SKIPPED ] Recordings.One (0 ms)</system-out></testcase>
  <testcase name="hw.Two" classname="c" time="0.01" status="notrun">
    <skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>
    <system-out>recordings_test.cpp:94: Skipped
people.csv is not here</system-out></testcase>
  <testcase name="python.udp" classname="d" time="0.01" status="run"><system-out>
test_six ... skipped 'no IPv6 here'
OK (skipped=1)</system-out></testcase>
</testsuite>
"""


class Summary(unittest.TestCase):
    def of(self, text):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "results.xml"
            file.write_text(text)
            return summary([str(file)])

    def test_skipped_is_not_passed(self):
        line, ran = self.of(RESULTS)
        self.assertEqual(line, "2 tests passed, 1 failed, 4 skipped: "
                         "check.firmware (no arm-none-eabi-gcc); "
                         "hw.One and 1 more (people.csv is not here); "
                         "1 of python.udp (no IPv6 here)")
        self.assertEqual(ran, 7)

    def test_nothing_skipped_needs_no_reason(self):
        self.assertEqual(self.of("<testsuite><testcase name='a' status='run'/></testsuite>"),
                         ("1 tests passed, 0 failed, 0 skipped", 1))

    def test_no_test_is_no_success(self):
        self.assertEqual(self.of("<testsuite/>")[1], 0)


if __name__ == "__main__":
    unittest.main()
