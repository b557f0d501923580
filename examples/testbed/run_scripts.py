"""Run mission scripts one after the other: run_scripts.py SITUATION SCRIPT...

Each gets 1 as its argument in a situation with a person, else 0.  They run where ROS writes, or in the folder that
TESTBED_FILES names, which then has their files and what they said in `said.txt`.  A script that fails ends this program
with its code; after the last one it waits for the flight's end.
"""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path


def main(situation, *scripts):
    """Run the scripts."""
    folder = Path(os.environ.get("TESTBED_FILES") or os.environ["ROS_HOME"])
    folder.mkdir(parents=True, exist_ok=True)
    person = re.search("H([01])", situation)
    with (folder / "said.txt").open("a") as said:
        for script in scripts:
            run = [sys.executable, "-u", script, person.group(1) if person else "0"]
            with subprocess.Popen(run, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as one:
                for line in one.stdout:
                    for sink in (said, sys.stdout):
                        sink.write(line)
                        sink.flush()
            if one.returncode:
                sys.exit(one.returncode)
    signal.pause()


if __name__ == "__main__":
    main(*sys.argv[1:])
