"""The punch: pressure and deformation near incompressibility."""
