"""``python -m studies.conservation``."""

from studies.conservation import STUDY
from studies.engine.study import run_study

if __name__ == "__main__":
    run_study(STUDY)
