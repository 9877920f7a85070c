from studies.engine.study import run_study
from studies.speed import STUDY

run_study(STUDY)
