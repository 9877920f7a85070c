"""``python -m studies.outside``."""

from studies.engine.study import run_study
from studies.outside import STUDY

if __name__ == "__main__":
    run_study(STUDY)
