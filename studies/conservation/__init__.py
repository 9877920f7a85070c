"""The L-shaped block and the spinning cube: momenta and energy."""
