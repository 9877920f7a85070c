"""The command line: ``sphsolid run|sweep|check|explain|view``, and the case files that it reads."""

from sphsolid.shell.case import Case, read_case
from sphsolid.shell.main import main

__all__ = ["Case", "main", "read_case"]
