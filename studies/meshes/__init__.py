"""Mesh files that studies run on, and the script that made them."""

from pathlib import Path

MESHES = Path(__file__).parent
