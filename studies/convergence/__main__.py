"""``python -m studies.convergence``; with ``--cloud`` it hands over to ``studies.clouds``."""

from __future__ import annotations

import sys

from studies.clouds.study import run as run_on_clouds
from studies.convergence.study import STUDY
from studies.harness.front import main

if __name__ == "__main__":
    if any(word.split("=")[0] == "--cloud" for word in sys.argv[1:]):
        sys.exit(run_on_clouds(sys.argv[1:]))
    sys.exit(main(STUDY))
