"""campaign.py against a program that prints what libFuzzer prints."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

CAMPAIGN = pathlib.Path(__file__).parent / "campaign.py"
# 400 executions per slice at most; coverage grows until LAST executions of a slice's count.
FAKE = """#!/bin/sh
for word; do case $word in
  -runs=*) runs=${word#-runs=} ;;
  -artifact_prefix=*) corpus=${word#-artifact_prefix=} ;;
esac; done
[ -z "$runs" ] && exit ALONE  # one input
[ "$runs" -gt 400 ] && runs=400
count=$(cat "$0.count" 2>/dev/null || echo 0)
count=$((count + 1)); echo $count > "$0.count"
[ "$count" = "FINDING" ] && { echo 'finding: wrong'; exit 77; }
edges=$count; [ $edges -gt GROWS ] && edges=GROWS
echo "#$runs	DONE   cov: $edges ft: $((2 * edges)) corp: 5/100b lim: 10 exec/s: 0 rss: 40Mb"
echo "stat::number_of_executed_units: $runs"
[ "$count" = "SLOW" ] && { touch "${corpus}timeout-1"; exit 70; }
exit 0
"""


class Campaign(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_to(self, executions, grows=2, finding="never", slow="never", alone=0):
        program = self.folder / "fuzzer"
        program.write_text(FAKE.replace("GROWS", str(grows)).replace("FINDING", finding)
                           .replace("SLOW", slow).replace("ALONE", str(alone)))
        program.chmod(0o755)
        done = subprocess.run([sys.executable, CAMPAIGN, program, self.folder / "corpus",
                               self.folder / "record.csv", executions],
                              capture_output=True, text=True)
        return done.returncode, done.stdout

    def slices(self):
        return len((self.folder / "record.csv").read_text().splitlines()) - 1

    def test_goes_on_after_its_last_slice(self):
        self.assertEqual(self.run_to("2000")[0], 0)
        self.assertEqual(self.slices(), 5)
        status, said = self.run_to("4e3")
        self.assertEqual((status, self.slices()), (0, 10))
        self.assertIn("4e+03 of 4e+03 executions", said)
        self.assertIn("corpus 5, edges 2, features 4; in the last tenth 0 new edges", said)
        self.assertEqual(self.run_to("4000")[0], 0)
        self.assertEqual(self.slices(), 10)  # nothing was left to do

    def test_growth_at_the_end_is_told(self):
        status, said = self.run_to("4000", grows=99)
        self.assertEqual(status, 3)
        self.assertIn("in the last tenth 1 new edges, 2 new features", said)

    def test_a_finding_ends_it(self):
        status, said = self.run_to("4000", finding="3")
        self.assertEqual((status, self.slices()), (1, 2))
        self.assertIn("a finding after 800 executions", said)

    def test_a_busy_host_is_no_finding(self):
        self.assertEqual(self.run_to("2000", slow="2", alone=70)[0], 0)
        self.assertEqual(self.slices(), 5)
        self.assertFalse(list((self.folder / "corpus").iterdir()))

    def test_a_slow_input_that_fails_is_one(self):
        status, said = self.run_to("2000", slow="2", alone=77)
        self.assertEqual((status, self.slices()), (1, 1))
        self.assertIn("a finding after 400 executions", said)


if __name__ == "__main__":
    unittest.main()
