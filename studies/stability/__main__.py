"""``python -m studies.stability``."""

from studies.engine.study import run_study
from studies.stability import STUDY

if __name__ == "__main__":
    run_study(STUDY)
