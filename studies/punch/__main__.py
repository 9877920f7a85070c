"""``python -m studies.punch``."""

from studies.engine.study import run_study
from studies.punch import STUDY

if __name__ == "__main__":
    run_study(STUDY)
