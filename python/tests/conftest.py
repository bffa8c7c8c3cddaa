"""What the tests share: the command line to compare with, to the bit."""

import json
import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def host_sim():
    """Runs ``host-sim`` and returns its JSON; the program is named by HOST_SIM, else the one that cargo builds."""
    program = os.environ.get("HOST_SIM")
    if program is None:
        subprocess.run(["cargo", "build", "-q", "-p", "host-sim"], cwd=ROOT, check=True)
        target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
        program = str(Path(target) / "debug" / "host-sim")

    def run(*arguments):
        words = [program, *(str(one) for one in arguments), "--format", "json"]
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        return json.loads(done.stdout)

    return run
